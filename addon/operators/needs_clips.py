"""What operators on clips need before they can run."""


class NeedsClips:
    """Mixin: a character, and at least one of its clips ticked."""

    @classmethod
    def poll(cls, context):
        settings = context.scene.wayfarer
        if settings.character is None:
            cls.poll_message_set("Choose a character first")
        elif not any(clip.use for clip in settings.clips):
            cls.poll_message_set("Give the character actions, refresh the clips and tick at least one")
        else:
            return True
        return False
