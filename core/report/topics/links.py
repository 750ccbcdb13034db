"""Links of the motion graph: uses of each, and the nodes that die without it."""

from collections.abc import Generator

import numpy as np

from ...embedding.embedding import Embedding
from ...evaluation.link_utility import LinkUtility, link_utility
from ...progress import Progress
from ..finding import Contribution, Finding, Questions, Topic
from ..page import Paragraph, Section
from ..quantity import Options, Quantity
from ..table import table


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    yield Progress(0.0, "Counting uses of links")
    return links_finding(embedding, link_utility(embedding), questions.thorough)


def links_finding(embedding: Embedding, found: LinkUtility, thorough: bool = True) -> Finding:
    """Tabulate the uses of each link of the motion graph, and the nodes that hang on it; most of them first."""
    order = np.lexsort((-found.link_uses, -found.link_dependents)).tolist()
    ends, costs = found.links.tolist(), embedding.graph.link_costs.tolist()
    rows = [
        (*(found.names[end] for end in ends[i]), int(found.link_uses[i]), int(found.link_dependents[i]), costs[i])
        for i in order
    ]
    links = table(("from", "to", "uses", "nodes that die without it", "cost (rad2)"), rows)

    def contribute() -> Contribution:
        shown = links.first(12 if thorough else 5)
        return Contribution(
            Section("Which links work?", (Paragraph(found.describe()), shown)),
            numbers={"idle_links": len(found.idle_links)},
            tables={"links": links},
        )

    return Finding(LINKS, embedding, links, sentences=(found.describe(),), contribute=contribute)


def _utility(embedding: Embedding, _: Options) -> LinkUtility:
    return link_utility(embedding)


def _greatest_share(hanging: np.ndarray, n_nodes: int) -> float:
    return int(hanging.max(initial=0)) / max(n_nodes, 1)


LINKS = Topic(
    "LINKS",
    "Links",
    _find_steps,
    section="links",
    quantities={
        "idle_transitions": Quantity(
            "links of the motion graph that are never played", lambda found: len(found.idle_links), find=_utility
        ),
        "spare_transitions": Quantity(
            "links of the motion graph without which no node dies at once",
            lambda found: int(np.count_nonzero(found.link_dependents == 0)),
            find=_utility,
        ),
        "vital_transition": Quantity(
            "share of the nodes that die at once without the link of the motion graph that most hangs on",
            lambda found: _greatest_share(found.link_dependents, found.n_nodes),
            find=_utility,
        ),
        "vital_segment": Quantity(
            "share of the nodes that die at once without the segment that most hangs on",
            lambda found: _greatest_share(found.segment_dependents, found.n_nodes),
            find=_utility,
        ),
    },
)
