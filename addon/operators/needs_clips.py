"""What operators on clips need before they can run."""

from ..bridge.clip_actions import character_problem


class NeedsClips:
    """Mixin: a character, and at least one of its clips ticked."""

    @classmethod
    def poll(cls, context):
        settings, problem = context.scene.wayfarer, character_problem(context.scene)
        if problem:
            cls.poll_message_set(problem)
        elif not any(clip.use for clip in settings.clips):
            cls.poll_message_set("Give the character actions, refresh the clips and tick at least one")
        else:
            return True
        return False
