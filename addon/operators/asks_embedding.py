"""What operators that ask questions of the embedding have in common."""

from ..jobs import LongOperator
from ..results.advice import stale_advice
from ..results.findings.finding import Finding, keep_finding
from ..results.state import embedding_of, results
from ..session import redraw

_REPORTED = 4
"""Numbers that the status bar has room for; the panel shows all of them."""


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


class FindsOut(LooksAtEmbedding, LongOperator):
    """Mixin: ``steps`` return a Finding, which is kept with the scene."""

    def apply(self, context, result: Finding):
        keep_finding(context.scene, result)
        # Lists are drawn from it.
        redraw()
        self.report({"INFO"}, self.summary(result))
        self.warn_if_stale(context.scene)

    def summary(self, finding: Finding) -> str:
        """What there is to report, without a full stop."""
        return ", ".join(f"{name}: {text}" for name, text in finding.numbers[:_REPORTED])
