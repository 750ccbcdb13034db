"""Foot contact clean-up: planted feet stay where they stand (after Kovar, Schreiner & Gleicher 2002b).

Kovar, Schreiner, Gleicher: "Footskate cleanup for motion capture editing", SCA 2002. For every plant the foot is
moved so that what it stands on keeps its place; in the free frames around it what that takes is eased in and out by
splines; thigh and shin follow by inverse kinematics, in closed form, and the foot keeps its orientation and height.

Where a leg would have to be straighter than it ever is, the hips are lowered a little, which is the paper's root
adjustment. The paper also stretches bones; here they keep their lengths, because most rigs' legs are connected bones,
which cannot be moved off their parents.

A plant during which the foot travels too far is held in several places, and the foot makes a step from each to the
next: it is lifted a little and eased over. That is not in the paper.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import convolve1d, distance_transform_edt, maximum_filter1d

from .. import wording
from ..errors import ClipError, WalkError
from ..motion import quat
from ..motion.body_size import relative_size
from ..motion.clip import MotionClip
from ..motion.contacts import ContactSettings, foot_joints
from ..motion.skeleton import Skeleton
from .coupled_joints import find_coupled_joints, move_coupled_joints
from .knee_easing import eased_foot_move
from .plants import Plant, SplitPlant, overlapping, repeated, split_plant, walk_plants
from .transitions import closing
from .two_bone import Leg, find_leg, leg_turns
from .walk import Walk

_USUAL_EXTENSION = 90
"""Percentile of how straight a standing leg is in the motion: as straight as that it may get by the clean-up."""
_LIFT, _LIFT_PER_METRE, _HIGHEST_LIFT = 0.03, 0.1, 0.06
"""Metres, at a person's size, that a foot is lifted by for a step, how much more for each metre it steps, the most."""
_RISE = 0.4
"""Share of a step in which the foot gets up, and in which it gets down."""
_OFF_GROUND = 0.01
"""Metres, likewise: a foot that is lifted by more than that is not on the ground."""


@dataclass(frozen=True)
class CleanupSettings:
    """Settings of how planted feet are held.

    Attributes
    ----------
    window : float
        Seconds before and after a plant in which the foot, the leg and the hips may change.
    max_shift : float
        Metres that a planted foot may be moved by, for a character of a person's size, in proportion for others; a
        plant that needs more is taken for two, with a step between them.
    max_drop : float
        Metres that the hips may be lowered by, likewise.
    contacts : ContactSettings
        When a foot is planted, and which bones the feet are.
    """

    window: float = 0.25
    max_shift: float = 0.15
    max_drop: float = 0.06
    contacts: ContactSettings = field(default_factory=ContactSettings)

    def __post_init__(self):
        if not (np.isfinite(self.window) and self.window > 0):
            raise WalkError(f"Feet cannot be eased into place within {self.window} s; give a positive duration.")
        if not (self.max_shift > 0 and self.max_drop >= 0):
            raise WalkError("Planted feet need a positive distance to be moved by, and a drop of zero or more.")


@dataclass(frozen=True)
class FootCleanup:
    """A motion clip whose planted feet stay in place, and what that took.

    Attributes
    ----------
    clip : MotionClip
        The motion; the one given where nothing could be done.
    plants : tuple of Plant
        Of the feet that were held.
    untreated : tuple of str
        For each foot that was left as it is, a sentence that says why.
    touched : (F,) bool array
        Frames whose pose is not that of the clip given.
    lifted : (F, 2) bool array
        Frames in which the left (right) foot has been lifted off the ground, for a step that the given clip lacks.
    largest_shift, largest_drop : float
        Metres that a planted foot was moved by at the most, and the hips lowered.
    """

    clip: MotionClip
    plants: tuple[Plant, ...]
    untreated: tuple[str, ...]
    touched: np.ndarray
    lifted: np.ndarray
    largest_shift: float = 0.0
    largest_drop: float = 0.0

    def describe(self) -> str:
        """A sentence or two for people."""
        if not self.plants:
            return " ".join(self.untreated) or "No foot is planted in this motion; nothing was changed."
        held = (
            f"{wording.counted(len(self.plants), 'plant')} held; feet moved by up to "
            f"{wording.small(self.largest_shift)}, hips lowered by up to {wording.small(self.largest_drop)}."
        )
        return " ".join([held, *self.untreated])


def clean_feet(
    walk: Walk, clip: MotionClip, settings: CleanupSettings | None = None, closed: bool = False
) -> FootCleanup:
    """Hold the planted feet of a walk's motion in place; see :func:`hold_plants`.

    ``clip`` is what :func:`.synthesis.synthesize` made of the walk; ``closed`` says, there as here, that it is
    repeated, so that feet that stand at its end go on standing at its start. A character whose feet are not known
    gets its motion back, and the reason.
    """
    settings = settings or CleanupSettings()
    try:
        plants = walk_plants(walk, settings.contacts)
    except ClipError as error:
        return _untouched(clip, str(error))
    if not closed:
        return hold_plants(clip, plants, settings)
    # The middle one of three laps knows what comes before and after it.
    lap = clip.n_frames - 1
    cleaned = hold_plants(_three_laps(clip), repeated(plants, lap, 3), settings)
    middle = slice(lap, 2 * lap + 1)
    away = clip.translations[-1, 0, :2] - clip.translations[0, 0, :2]
    translations = cleaned.clip.translations[middle].copy()
    translations[:, 0, :2] -= away
    held = [
        plant.within(lap, 2 * lap).later(-lap) for plant in cleaned.plants if plant.first < 2 * lap and plant.last > lap
    ]
    return replace(
        cleaned,
        clip=replace(clip, rotations=cleaned.clip.rotations[middle], translations=translations),
        plants=tuple(held),
        touched=cleaned.touched[middle],
        lifted=cleaned.lifted[middle],
    )


def _untouched(clip: MotionClip, *reasons: str) -> FootCleanup:
    return FootCleanup(clip, (), reasons, np.zeros(clip.n_frames, dtype=bool), np.zeros((clip.n_frames, 2), dtype=bool))


def _three_laps(clip: MotionClip) -> MotionClip:
    """Return a motion that ends as it starts three times over, each time from where it has come to."""
    lap = clip.n_frames - 1
    frames = np.append(np.tile(np.arange(lap), 3), lap)
    number = np.minimum(np.arange(3 * lap + 1) // lap, 2)
    translations, heading = clip.translations[frames], clip.ground_path[:, 2]
    translations[:, 0, :2] += number[:, None] * (clip.translations[-1, 0, :2] - clip.translations[0, 0, :2])
    heading = heading[frames] + number * (heading[-1] - heading[0])
    return replace(clip, rotations=clip.rotations[frames], translations=translations, heading=heading, tags={})


def hold_plants(clip: MotionClip, plants: Sequence[Plant], settings: CleanupSettings | None = None) -> FootCleanup:
    """Hold the feet of a motion in place on the ground during the given plants.

    Frames farther than the window from every plant stay exactly as they are. Where the hips are lowered, feet in the
    air keep their place, too. For a step between parts of a plant (:func:`.plants.split_plant`) a foot is lifted; but
    for that its height does not change, nor do its orientation, the root path and bone lengths.

    Raises
    ------
    ClipError
        The feet are not known.
    """
    settings = settings or CleanupSettings()
    skeleton = clip.skeleton
    feet = foot_joints(skeleton, settings.contacts.feet)
    found = [find_leg(skeleton, side, feet) for side in (0, 1)]
    legs = {side: leg for side, leg in enumerate(found) if isinstance(leg, Leg)}
    untreated = tuple(reason for reason in found if isinstance(reason, str))
    window = max(round(settings.window * clip.frame_rate), 1)
    size = relative_size(skeleton)
    rotations, positions = clip.world
    stances = [
        split_plant(plant, positions, settings.max_shift * size, window)
        for plant in overlapping(plants)
        if plant.side in legs
    ]
    held = [plant for stance in stances for plant in stance.parts]
    if not held:
        return _untouched(clip, *untreated)

    moves = {side: _foot_moves([s for s in stances if s.plant.side == side], positions, window, size) for side in legs}
    lifted = np.zeros((clip.n_frames, 2), dtype=bool)
    for side, move in moves.items():
        lifted[:, side] = move[:, 2] > _OFF_GROUND * size
    drop = _drop(legs, moves, held, positions, window, settings.max_drop * size)
    hips_move = -drop[:, None] * [0.0, 0.0, 1.0]
    for side, leg in legs.items():
        planted = np.zeros(clip.n_frames, dtype=bool)
        for plant in held:
            if plant.side == side:
                planted[plant.first : plant.last + 1] = True
        moves[side] = eased_foot_move(leg, positions, hips_move, moves[side], planted, clip.frame_rate)
    touched = np.any([np.any(move != 0, axis=1) for move in moves.values()], axis=0) | (drop > 0)
    new_rotations, new_translations = clip.rotations.copy(), clip.translations.copy()
    lowered = _lowered_joint(skeleton, list(legs.values()))
    above = skeleton.parents[lowered]
    carried = hips_move if above < 0 else quat.rotate(quat.inverse(rotations[:, above]), hips_move)
    new_translations[touched, lowered] += carried[touched]
    for side, leg in legs.items():
        frames = np.flatnonzero(np.any(moves[side] != 0, axis=1) | (drop > 0))
        if len(frames):
            _turn_leg(leg, skeleton, rotations, positions, hips_move, moves[side], frames, new_rotations)
    coupled = find_coupled_joints(skeleton, list(legs.values()), rotations, positions)
    move_coupled_joints(
        coupled, skeleton, (rotations, positions), new_rotations, new_translations, np.flatnonzero(touched)
    )
    return FootCleanup(
        clip=replace(clip, rotations=new_rotations, translations=new_translations),
        plants=tuple(held),
        untreated=untreated,
        touched=touched,
        lifted=lifted,
        largest_shift=max(
            float(np.linalg.norm(moves[plant.side][plant.first : plant.last + 1, :2], axis=1).max()) for plant in held
        ),
        largest_drop=float(drop.max()),
    )


def _foot_moves(stances: list[SplitPlant], positions: np.ndarray, window: int, size: float) -> np.ndarray:
    """Return (F, 3) metres that a foot moves by: what its plants take, eased in and out by splines, and its lifts.

    Each part of a stance has the place that moves the foot the least, in the mean square.
    """
    n_frames = len(positions)
    moves = np.zeros((n_frames, 3))
    for i, stance in enumerate(stances):
        plant, parts = stance.plant, stance.parts
        # With this alone the foot would stand where the plant begins, all the time.
        shift = plant.shift(positions)
        places = [shift[p.first - plant.first : p.last + 1 - plant.first].mean(axis=0) for p in parts]
        for held, place in zip(parts, places, strict=True):
            moves[held.first : held.last + 1, :2] = (
                shift[held.first - plant.first : held.last + 1 - plant.first] - place
            )
        for (before, start), (after, end) in pairwise(zip(parts, places, strict=True)):
            frames = np.arange(before.last + 1, after.first)
            share = (frames - before.last) / (after.first - before.last)
            # Neither speed nor acceleration at either end: where the foot is still low, it hardly travels.
            ease = share**3 * (10 - 15 * share + 6 * share**2)
            moves[frames, :2] = shift[frames - plant.first] - start - ease[:, None] * (end - start)
            moves[frames, 2] += _lift(share, end - start, size)
        first, last = parts[0].first, parts[-1].last
        if first == last:
            continue
        # In the free frames the foot goes on as it comes from where it stands.
        limits = (
            stances[i - 1].parts[-1].last if i > 0 else -window,
            stances[i + 1].parts[0].first if i + 1 < len(stances) else n_frames,
        )
        for edge, step, free, cut, way in (
            (first, -1, first - limits[0], first - plant.first, shift[first - plant.first] - shift[0]),
            (last, 1, limits[1] - last, plant.last - last, shift[-1] - shift[last - plant.first]),
        ):
            inner = moves[[edge, edge - step], :2]
            reach = min(window + cut, free)
            steps = np.arange(1, reach)
            frames = edge + step * steps
            inside = (frames >= 0) & (frames < n_frames)
            value, slope = closing(steps[inside], reach)
            moves[frames[inside], :2] += value[:, None] * inner[0] + slope[:, None] * (inner[0] - inner[1])
            if cut > 0:
                moves[frames[inside], 2] += _lift(steps[inside] / reach, way, size)
    return moves


def _lift(share: np.ndarray, way: np.ndarray, size: float) -> np.ndarray:
    """Return (n,) metres that a foot is lifted by at shares of a step that takes it some ``way``, a (2,) array."""
    height = min(_LIFT + _LIFT_PER_METRE * float(np.linalg.norm(way)) / size, _HIGHEST_LIFT) * size
    # Up early and down late, so that the foot is in the air while it travels.
    return height * (1 - closing(share / _RISE, 1)[0]) * (1 - closing((1 - share) / _RISE, 1)[0])


def _drop(
    legs: dict[int, Leg], moves: dict[int, np.ndarray], plants: list[Plant], positions: np.ndarray, window: int, most
) -> np.ndarray:
    """Return (F,) metres to lower the hips by, smoothly, so that no leg gets straighter than usual."""
    n_frames = len(positions)
    needed = np.zeros(n_frames)
    near = np.zeros(n_frames, dtype=bool)
    for plant in plants:
        near[plant.first : plant.last + 1] = True
    for side, leg in legs.items():
        hip, knee, ankle = (positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
        length = np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
        extension = np.linalg.norm(ankle - hip, axis=1) / length
        reach = np.maximum(extension, np.percentile(extension[near], _USUAL_EXTENSION)) * length
        away = ankle + moves[side] - hip
        below = np.sqrt(np.maximum(reach**2 - np.sum(away[:, :2] ** 2, axis=1), 0.0))
        lacking = np.where(np.linalg.norm(away, axis=1) > reach + 1e-9, -away[:, 2] - below, 0.0)
        needed = np.maximum(needed, lacking)
    # The mean of what is the most within half a window is nowhere less than what is needed.
    half = max(window // 2, 1)
    envelope = maximum_filter1d(np.clip(needed, 0.0, most), 2 * half + 1, mode="nearest")
    kernel = np.hanning(2 * half + 3)[1:-1]
    smooth = convolve1d(envelope, kernel / kernel.sum(), mode="nearest")
    return smooth * _nearness(near, window)


def _nearness(near: np.ndarray, window: int) -> np.ndarray:
    """Return (F,) 1 up to half of ``window`` frames around what is ``near``, falling to 0 at its end."""
    away = np.asarray(distance_transform_edt(~near))
    return closing(np.maximum(away - window // 2, 0), window - window // 2)[0]


def _lowered_joint(skeleton: Skeleton, legs: list[Leg]) -> int:
    """Return the joint that carries the body: the highest above all legs that is not on the ground itself."""
    chains = [skeleton.ancestors(leg.thigh)[::-1] for leg in legs]
    shared = [joint for joint in chains[0] if all(joint in chain for chain in chains)]
    height = skeleton.rest_world[1][:, 2] - skeleton.rest_world[1][:, 2].min()
    hips = shared[-1]
    return next(joint for joint in shared if height[joint] >= height[hips] / 2)


def _turn_leg(leg: Leg, skeleton: Skeleton, rotations, positions, hips_move, foot_move, frames, new_rotations) -> None:
    """Turn thigh, shin and foot in ``new_rotations`` (F, J, 4), relative to their parents, on the given frames."""
    thigh, shin = leg_turns(leg, rotations[frames], positions[frames], hips_move[frames], foot_move[frames])
    # What carries each joint has been turned by the one above: the foot is turned back to what it was.
    none = quat.IDENTITY
    for joint, above, turn in ((leg.thigh, none, thigh), (leg.shin, thigh, shin), (leg.foot, shin, none)):
        back = quat.inverse(quat.multiply(above, rotations[frames, skeleton.parents[joint]]))
        new_rotations[frames, joint] = quat.multiply(back, turn, rotations[frames, joint])
