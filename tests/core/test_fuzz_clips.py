"""Any clips whatever make a sound motion graph or a sentence: never another error, never a graph of nonsense."""

import os

import numpy as np
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from core.embedding.embedding import EmbeddingSettings, embed
from core.environment.environment import Environment
from core.environment.grid import Grid
from core.errors import MotionGraphError
from core.motion.clip import MotionClip
from core.motion.contacts import ContactSettings, foot_contacts
from core.motion.doctor import examine
from core.motion.graph import MotionGraph, MotionGraphSettings, build_motion_graph
from core.motion.heading import with_steady_heading
from core.motion.mirror import mirrored
from core.motion.skeleton import Skeleton

# Nightly: WAYFARER_FUZZ=100 tries a hundred times as many.
EFFORT = int(os.environ.get("WAYFARER_FUZZ", "1"))
BODY = (
    "Hips",
    "LeftUpLeg",
    "LeftLeg",
    "LeftFoot",
    "RightUpLeg",
    "RightLeg",
    "RightFoot",
    "Spine",
    "LeftArm",
    "RightArm",
)
STRANGE = (np.nan, np.inf, -np.inf, 1e308, -1e200, 1e30, 1e-320, 0.0)
RATES = (30.0, 120.0, 24.0, 1.0, 0.0, -30.0, np.nan, np.inf, 1e-300, 1e9)


@st.composite
def skeletons(draw) -> Skeleton:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(1, len(BODY)))
    names = list(BODY[:n])
    if draw(st.integers(0, 5)) == 0:
        names = draw(st.lists(st.sampled_from([*BODY, "", "Bone", "Bone.001", "骨", "a\nb"]), min_size=n, max_size=n))
    parents = np.array([-1, *(int(rng.integers(0, joint)) for joint in range(1, n))])
    rotations = rng.normal(size=(n, 4))
    rotations /= np.linalg.norm(rotations, axis=1, keepdims=True)
    translations = rng.normal(0, draw(st.sampled_from([0.0, 0.4, 40.0, 1e-9])), (n, 3))
    forward = np.array(draw(st.sampled_from([(1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, 0), (np.nan, 0, 0)])), float)
    corrupt(draw, rotations, 0.05)
    corrupt(draw, translations, 0.05)
    return Skeleton(tuple(names), parents, rotations, translations, forward)


@st.composite
def clips(draw, skeleton: Skeleton) -> MotionClip:
    """Smooth motion, with a defect now and then."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n_frames, n_joints = draw(st.integers(1, 90)), skeleton.n_joints
    times = np.linspace(0, draw(st.sampled_from([0.5, 6.0, 30.0])), n_frames)[:, None, None]
    rotations = np.sin(times + rng.uniform(0, 6, (1, n_joints, 4)))
    rotations *= draw(st.sampled_from([1.0, 3.0, 1e-12]))
    if draw(st.booleans()):
        rotations /= np.linalg.norm(rotations, axis=2, keepdims=True)
    translations = np.sin(times + rng.uniform(0, 6, (1, n_joints, 3))) * draw(st.sampled_from([0.0, 0.5, 100.0]))
    if draw(st.booleans()):
        # Periodic and upright: something that can connect.
        rotations[:, 0] = (1, 0, 0, 0)
        translations[:, 0, :2] = np.linspace(0, 3, n_frames)[:, None]
    corrupt(draw, rotations, 0.15)
    corrupt(draw, translations, 0.15)
    tags = {"step": rng.random(n_frames) < 0.3} if draw(st.booleans()) else {}
    rate = draw(st.sampled_from(RATES)) if draw(st.integers(0, 7)) == 0 else 30.0
    return MotionClip(draw(st.sampled_from(["walk", "run", ""])), skeleton, rate, rotations, translations, tags)


def corrupt(draw, values: np.ndarray, share: float) -> None:
    """Now and then put something strange into an array: one number, or a whole row of them."""
    if draw(st.floats(0, 1)) < share and values.size:
        value = draw(st.sampled_from(STRANGE))
        place = np.unravel_index(draw(st.integers(0, values.size - 1)), values.shape)
        values[place if draw(st.booleans()) else place[:-1]] = value


@st.composite
def clip_lists(draw) -> list[MotionClip]:
    skeleton = draw(skeletons())
    return [draw(clips(skeleton)) for _ in range(draw(st.integers(1, 3)))]


def attempted(make, *arguments):
    """What came of it, or the sentence of why nothing did; whatever else is raised fails the test."""
    try:
        return make(*arguments)
    except MotionGraphError as error:
        sentence = str(error)
        assert sentence.endswith(".") and len(sentence) > 20 and "Traceback" not in sentence, sentence
        return sentence


def assert_sound(graph: MotionGraph, given_settings: MotionGraphSettings) -> None:
    n = len(graph.segments)
    assert n > 0 and graph.links.shape == (len(graph.link_costs), 2)
    assert graph.links.min() >= 0 and graph.links.max() < n
    assert len(np.unique(graph.links, axis=0)) == len(graph.links)
    assert np.isfinite(graph.link_costs).all() and np.all(graph.link_costs >= 0)
    matrix = csr_array((np.ones(len(graph.links)), graph.links.T), shape=(n, n))
    assert connected_components(matrix, connection="strong")[0] == 1
    for segment in graph.segments:
        assert segment.n_frames > given_settings.min_gap - 1 and segment.duration > 0
        assert segment.path.shape == (segment.n_frames, 3) and np.isfinite(segment.path).all()
        np.testing.assert_allclose(segment.path[0], 0, atol=1e-9)
        assert 0 <= segment.first < segment.last < graph.clips[segment.clip].n_frames
        assert all(mask.shape == (segment.n_frames,) for mask in segment.tags.values())


@settings(max_examples=40 * EFFORT, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_clips_make_a_sound_graph_or_a_sentence(data):
    made = attempted(data.draw, clip_lists())
    assume(not isinstance(made, str))
    wanted = MotionGraphSettings(
        max_cost=data.draw(st.sampled_from([0.3, 30.0, 1e6])),
        min_segment_duration=data.draw(st.sampled_from([0.1, 0.67])),
        contacts=ContactSettings(feet=((made[0].skeleton.names[-1],), (made[0].skeleton.names[0],))),
        n_starts=1,
    )
    graph = attempted(build_motion_graph, made, wanted)
    if isinstance(graph, str):
        return
    assert_sound(graph, wanted)
    grid = Grid((6, 6, 4), 0.5)
    embedding = attempted(
        embed, graph, Environment(grid, np.zeros((24, 24), bool)), EmbeddingSettings(memory_limit=1e8)
    )
    if not isinstance(embedding, str):
        assert embedding.n_nodes >= 0 and embedding.n_links >= 0


@settings(max_examples=40 * EFFORT, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_every_question_about_a_clip_has_an_answer_or_a_sentence(data):
    made = attempted(data.draw, clip_lists())
    assume(not isinstance(made, str))
    for clip in made:
        path = attempted(lambda clip: clip.ground_path, clip)
        assert isinstance(path, str) or np.isfinite(path).all()
        contacts = attempted(foot_contacts, clip)
        assert isinstance(contacts, str) or contacts.shape == (clip.n_frames, 2)
        again = attempted(mirrored, clip)
        assert isinstance(again, str) or again.n_frames == clip.n_frames
        steadied = attempted(with_steady_heading, clip)
        assert isinstance(steadied, str) or np.isfinite(steadied.ground_path).all()
        slower = attempted(clip.resampled, 10.0)
        assert isinstance(slower, str) or np.isfinite(slower.rotations).all()
        attempted(examine, clip)
