"""What operators that ask questions of the embedding have in common."""

from ..results.advice import stale_advice
from ..results.store import embedding_of, results


class LooksAtEmbedding:
    """Mixin: an embedding, be it an empty one."""

    @classmethod
    def poll(cls, context):
        if results(context.scene).embedding is None:
            cls.poll_message_set("Embed the motion graph first")
            return False
        return True

    def warn_if_stale(self, scene) -> None:
        """Say so if something has changed since the embedding was made; last, so that it stays to be read."""
        for sentence in stale_advice(scene):
            self.report({"WARNING"}, sentence)


class AsksEmbedding(LooksAtEmbedding):
    """Mixin: an embedding in which the character can go somewhere."""

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if embedding_of(context.scene).n_nodes == 0:
            cls.poll_message_set("The character cannot go anywhere in this scene; the embedding is empty")
            return False
        return True
