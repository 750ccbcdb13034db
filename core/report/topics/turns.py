"""Turn balance: left against right."""

from collections.abc import Generator

from ...embedding.embedding import Embedding
from ...evaluation.turn_balance import TurnBalance, turn_balance
from ...progress import Progress
from ..finding import Contribution, Finding, Questions, Topic
from ..floor_chart import balance_chart
from ..page import Figure, FigureRow, Paragraph, Section
from ..quantity import Options, Quantity


def _find_steps(embedding: Embedding, questions: Questions) -> Generator[Progress, None, Finding]:
    yield Progress(0.0, "Counting turns")
    found = turn_balance(embedding)
    return Finding(
        TURNS,
        embedding,
        sentences=(found.describe(),),
        contribute=lambda: _contribution(embedding, questions, found),
    )


def _contribution(embedding: Embedding, questions: Questions, found: TurnBalance) -> Contribution:
    chart = balance_chart(questions.floor_scene(embedding), "Turn balance", found.balance, "right", "left")
    caption = "Angles that the links starting at a place turn by: orange where they turn right, blue where left."
    return Contribution(
        Section("Does it turn both ways?", (Paragraph(found.describe()), FigureRow((Figure(chart, caption),)))),
        numbers={
            "turn_balance": found.total,
            "links_left": found.n_left,
            "links_right": found.n_right,
            "links_straight": found.n_straight,
        },
        maps={"turn_balance": chart},
    )


def _turns(embedding: Embedding, _: Options) -> TurnBalance:
    return turn_balance(embedding)


TURNS = Topic(
    "TURNS",
    "Turn Balance",
    _find_steps,
    section="turns",
    quantities={
        "turn_balance": Quantity("left (1) or right (-1)", lambda found: found.total, find=_turns),
        "left_links": Quantity("links that turn left", lambda found: found.n_left, find=_turns),
        "right_links": Quantity("links that turn right", lambda found: found.n_right, find=_turns),
        "straight_links": Quantity("links that do not turn", lambda found: found.n_straight, find=_turns),
    },
)
