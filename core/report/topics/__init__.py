"""Topics: a file for each question about an embedding, with all that panels, pages, files and studies say."""

from ..finding import Topic
from .capture import CAPTURE
from .coverage import COVERAGE
from .detours import DETOURS
from .importance import ABLATION, DELETION, IMPORTANCE
from .links import LINKS
from .metrics import ACTIONS, METRICS
from .occupancy import OCCUPANCY
from .pruning import PRUNING, PRUNING_CURVE
from .times import REACH
from .turns import TURNS
from .weak_spots import WEAK_SPOTS

#: All topics, in the order of panels and exports.
TOPICS: tuple[Topic, ...] = (
    METRICS,
    ACTIONS,
    LINKS,
    WEAK_SPOTS,
    ABLATION,
    DELETION,
    CAPTURE,
    OCCUPANCY,
    PRUNING,
    PRUNING_CURVE,
    REACH,
    COVERAGE,
    IMPORTANCE,
    DETOURS,
    TURNS,
)

#: Those of a report, in the order of its page.
SECTIONS: tuple[Topic, ...] = (
    COVERAGE,
    WEAK_SPOTS,
    CAPTURE,
    IMPORTANCE,
    REACH,
    DETOURS,
    TURNS,
    OCCUPANCY,
    METRICS,
    PRUNING_CURVE,
    LINKS,
)
