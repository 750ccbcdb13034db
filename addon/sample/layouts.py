"""The sample scenes as plans: like those of the paper's figures, with walls, furniture and steps to be stepped over.

All lie around the world's origin. Walls are low, so that the scenes can be seen from outside.
"""

from dataclasses import dataclass

#: Metres by which a step is grown: the planted feet stay off it, and the root's travel in a step over spans it.
STEP_MARGIN = 0.3

WALL_THICKNESS, WALL_HEIGHT = 0.12, 0.55


@dataclass(frozen=True)
class Block:
    """Something that stands in the way: a box, or a round pillar as wide as it is deep; metres."""

    name: str
    x: float
    y: float
    width: float
    depth: float
    height: float
    is_round: bool = False


@dataclass(frozen=True)
class SceneLayout:
    """A sample scene.

    Attributes
    ----------
    key : str
        The choice in the menu, and in lower case the name of the file.
    label, description : str
        For people; the description is a tooltip.
    size : (width, depth)
        Metres.
    blocks : tuple of Block
    steps : tuple of float
        For each step, across the whole width, the y of its middle.
    is_walled : bool
        Whether walls stand around the ground.
    cell_size : float
        Metres.
    is_tiled : bool
    """

    key: str
    label: str
    description: str
    size: tuple[float, float]
    blocks: tuple[Block, ...]
    steps: tuple[float, ...] = ()
    is_walled: bool = True
    cell_size: float = 0.1
    n_headings: int = 24
    is_tiled: bool = False

    @property
    def file_name(self) -> str:
        return f"{self.key.lower()}.blend"

    def all_blocks(self) -> tuple[Block, ...]:
        """The walls around the ground, then everything else."""
        return (*_walls(*self.size), *self.blocks) if self.is_walled else self.blocks


def _walls(width: float, depth: float) -> tuple[Block, ...]:
    outside = width + 2 * WALL_THICKNESS
    beside, beyond = (width + WALL_THICKNESS) / 2, (depth + WALL_THICKNESS) / 2
    return (
        Block("Wall Left", -beside, 0.0, WALL_THICKNESS, depth, WALL_HEIGHT),
        Block("Wall Right", beside, 0.0, WALL_THICKNESS, depth, WALL_HEIGHT),
        Block("Wall Near", 0.0, -beyond, outside, WALL_THICKNESS, WALL_HEIGHT),
        Block("Wall Far", 0.0, beyond, outside, WALL_THICKNESS, WALL_HEIGHT),
    )


def _pillar(name: str, x: float, y: float) -> Block:
    return Block(name, x, y, 0.36, 0.36, 1.7, is_round=True)


_FURNITURE = (
    _pillar("Pillar A", -1.35, -0.55),
    _pillar("Pillar B", 1.45, -2.05),
    Block("Table", -2.2, -2.95, 1.1, 0.7, 0.74),
    Block("Crate", 2.85, 0.1, 0.6, 0.6, 0.6),
    Block("Cupboard", 0.4, 3.72, 1.3, 0.45, 0.9),
)

LAYOUTS = (
    SceneLayout(
        key="STEP_ROOM",
        label="Room With a Step",
        description="A room of 7 x 8 m; only steps over lead into its far end (the paper's Fig. 1)",
        size=(7.0, 8.0),
        blocks=_FURNITURE,
        steps=(1.45,),
    ),
    SceneLayout(
        key="ROOM",
        label="Room",
        description="The same room of 7 x 8 m without the step",
        size=(7.0, 8.0),
        blocks=_FURNITURE,
    ),
    SceneLayout(
        key="TWO_STEPS",
        label="Room With Two Steps",
        description="A room of 7 x 8 m in three parts, with a step between each two (the paper's Fig. 10)",
        size=(7.0, 8.0),
        blocks=(
            _pillar("Pillar A", -1.6, 0.15),
            _pillar("Pillar B", 1.9, -2.75),
            Block("Crate", 2.85, 0.0, 0.6, 0.6, 0.6),
            Block("Cupboard", -0.9, 3.72, 1.3, 0.45, 0.9),
        ),
        steps=(-1.45, 1.75),
    ),
    SceneLayout(
        key="S_HALL",
        label="S-Shaped Hall",
        description="A hall of 7 x 8 m that two walls fold into an S (the paper's Fig. 10)",
        size=(7.0, 8.0),
        blocks=(
            Block("Fold Near", -1.1, -1.36, 4.8, WALL_THICKNESS, WALL_HEIGHT),
            Block("Fold Far", 1.1, 1.36, 4.8, WALL_THICKNESS, WALL_HEIGHT),
        ),
    ),
    SceneLayout(
        key="TILE",
        label="Tile",
        description="A ground of 6 x 6 m that repeats on all sides (the paper's Fig. 9)",
        size=(6.0, 6.0),
        blocks=(
            Block("Kiosk", -1.45, 1.3, 1.2, 0.8, 1.6),
            Block("Planter", 1.75, 1.6, 0.9, 0.9, 0.5),
            _pillar("Pillar A", 1.25, -1.15),
            _pillar("Pillar B", -1.6, -1.75),
        ),
        is_walled=False,
        cell_size=0.15,
        is_tiled=True,
    ),
)


def layout_of(key: str) -> SceneLayout:
    """The layout with this key; StopIteration if there is none."""
    return next(layout for layout in LAYOUTS if layout.key == key)
