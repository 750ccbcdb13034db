"""What operators on the character itself need before they can run."""


class NeedsCharacter:
    """Mixin: a character."""

    @classmethod
    def poll(cls, context):
        if context.scene.wayfarer.character is None:
            cls.poll_message_set("Choose a character first")
            return False
        return True
