"""What operators that let characters walk need before they can run."""

from ..bridge.clip_actions import character_problem
from .asks_embedding import AsksEmbedding


class NeedsEmbedding(AsksEmbedding):
    """Mixin: a character, and an embedding in which it can go somewhere."""

    @classmethod
    def poll(cls, context):
        problem = character_problem(context.scene)
        if problem:
            cls.poll_message_set(problem)
        return not problem and super().poll(context)
