"""Cuts against exhaustive search on problems small enough for it."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_matrix

from core.motion.connecting import kept_goodness, reconnect_steps
from core.motion.cutting import CONTINUATION, best_cuts, cut_steps
from core.progress import finish

from .cuttings import exhaustive_best, greedy_cuts, spaced, total_goodness


def cut_solutions(*arguments):
    return finish(cut_steps(*arguments))


def segments_of(all_cuts, lengths):
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    return [
        (int(offset + a), int(offset + b))
        for offset, cuts in zip(offsets, all_cuts, strict=False)
        for a, b in pairwise(cuts)
    ]


def obvious_links(goodness, lengths, all_cuts):
    """(from, to, goodness) of every link between segments, by a double loop."""
    segments = segments_of(all_cuts, lengths)
    links = []
    for i, (_, end) in enumerate(segments):
        for j, (start, _) in enumerate(segments):
            if end == start:
                links.append((i, j, CONTINUATION))
            elif goodness[end, start] > 0:
                links.append((i, j, goodness[end, start]))
    return links


def random_goodness(rng, lengths, min_gap, density=0.1, within=True):
    n_frames = sum(lengths)
    owner = np.repeat(np.arange(len(lengths)), lengths)
    values = np.triu(rng.random((n_frames, n_frames)) * (rng.random((n_frames, n_frames)) < density), 1)
    frames = np.arange(n_frames)
    close = np.abs(frames[:, None] - frames) < (min_gap if within else n_frames)
    values[close & (owner[:, None] == owner)] = 0
    return values + values.T


values = st.lists(st.floats(0, 5, allow_subnormal=False).map(lambda x: round(x, 3)), min_size=1, max_size=11)


@given(values, st.integers(1, 5), st.randoms(use_true_random=False))
def test_the_cuts_of_one_clip_are_the_best_there_are(start_value, min_gap, random):
    n_frames = len(start_value)
    end_value = [random.choice([0, random.random() * 5]) for _ in start_value]
    may_open = np.array([random.random() < 0.7 for _ in start_value])
    may_close = np.array([random.random() < 0.7 for _ in start_value])

    def worth(cuts):
        if len(cuts) == 0:
            return 0.0
        inner = sum(start_value[c] + end_value[c] + CONTINUATION for c in cuts[1:-1])
        return start_value[cuts[0]] + inner + end_value[cuts[-1]]

    cases = [(None, None), (may_open, may_close)]
    for opening, closing in cases:
        found = best_cuts(np.array(start_value), np.array(end_value), min_gap, opening, closing)
        allowed = [
            cuts
            for cuts in spaced(n_frames, min_gap)
            if not cuts or opening is None or (opening[cuts[0]] and closing[cuts[-1]])
        ]
        assert tuple(found.tolist()) in allowed
        assert worth(found) == pytest.approx(max(map(worth, allowed)))


def test_total_goodness_counts_every_link_once():
    rng = np.random.default_rng(0)
    lengths = [12, 9, 15]
    goodness = random_goodness(rng, lengths, 3, density=0.5)
    cuts = [np.array([0, 4, 8]), np.array([], dtype=int), np.array([1, 4, 9, 14])]
    links = obvious_links(goodness, lengths, cuts)
    total = total_goodness(csr_matrix(goodness), lengths, cuts)
    assert total == pytest.approx(sum(value for _, _, value in links))
    assert {value for _, _, value in links} > {CONTINUATION}


def test_cuts_of_small_problems_are_mostly_the_best_there_are():
    rng = np.random.default_rng(1)
    lengths, min_gap = [7, 8], 3
    equal = 0
    for _ in range(20):
        goodness = random_goodness(rng, lengths, min_gap, density=0.3)
        sparse = csr_matrix(goodness)
        solutions = cut_solutions(sparse, lengths, min_gap, 8, np.random.default_rng(0))
        found = max(total_goodness(sparse, lengths, cuts) for cuts in solutions)
        best = exhaustive_best(sparse, lengths, min_gap, total_goodness)
        assert found <= best + 1e-9
        assert found > 0.7 * best
        equal += found > best - 1e-9
    assert equal >= 16


@pytest.mark.parametrize("seed", range(5))
def test_no_clip_can_be_cut_better_while_the_others_stay(seed):
    rng = np.random.default_rng(seed)
    lengths, min_gap = [9, 10, 11, 8], 3
    goodness = csr_matrix(random_goodness(rng, lengths, min_gap, within=False))
    for cuts in cut_solutions(goodness, lengths, min_gap, 4, rng):
        total = total_goodness(goodness, lengths, cuts)
        assert total > 0
        for clip, length in enumerate(lengths):
            for other in spaced(length, min_gap):
                attempt = [*cuts[:clip], np.array(other, dtype=int), *cuts[clip + 1 :]]
                assert total_goodness(goodness, lengths, attempt) <= total + 1e-9


def random_problem(seed):
    rng = np.random.default_rng(seed)
    lengths, min_gap = [30, 5, 40, 25, 50], 6
    return csr_matrix(random_goodness(rng, lengths, min_gap, density=0.02)), lengths, min_gap


def test_cuts_keep_their_distance_and_reconnecting_never_keeps_less():
    gained = 0.0
    for seed in range(5):
        goodness, lengths, min_gap = random_problem(seed)
        for cuts in cut_solutions(goodness, lengths, min_gap, 3, np.random.default_rng(0)):
            before = kept_goodness(goodness, lengths, cuts)
            better, kept = finish(reconnect_steps(goodness, lengths, min_gap, cuts))
            assert kept == pytest.approx(kept_goodness(goodness, lengths, better))
            assert kept >= before - 1e-9
            for frames, length in zip(better, lengths, strict=True):
                assert len(frames) != 1
                assert (np.diff(frames) >= min_gap).all()
                assert ((frames >= 0) & (frames < length)).all()
            assert len(better[1]) == 0  # five frames hold no segment of six
            gained += kept - before
    assert gained > 0


def obvious_kept(goodness, lengths, cuts):
    """Goodness within the largest component, by walking from every segment."""
    n_segments = len(segments_of(cuts, lengths))
    links = obvious_links(goodness, lengths, cuts)
    reach = np.zeros((n_segments, n_segments), dtype=bool)
    for i, j, _ in links:
        reach[i, j] = True
    for middle in range(n_segments):
        reach |= reach[:, [middle]] & reach[[middle]]
    both = reach & reach.T
    best = (0, 0, 0.0)
    for members in both:
        inner = [value for i, j, value in links if members[i] and members[j]]
        best = max(best, (int(members.sum()), len(inner), sum(inner)))
    return best[2]


@pytest.mark.parametrize("seed", range(4))
def test_kept_goodness_is_that_of_an_obvious_component(seed):
    goodness, lengths, min_gap = random_problem(seed)
    for cuts in cut_solutions(goodness, lengths, min_gap, 3, np.random.default_rng(seed)):
        better, _ = finish(reconnect_steps(goodness, lengths, min_gap, cuts))
        for choice in (cuts, better):
            expected = obvious_kept(goodness.toarray(), lengths, choice)
            assert kept_goodness(goodness, lengths, choice) == pytest.approx(expected)
            assert expected > 0


def test_reconnected_cuts_of_small_problems_are_mostly_the_best_there_are():
    rng = np.random.default_rng(2)
    lengths, min_gap = [7, 8], 3
    shares = []
    for _ in range(20):
        goodness = csr_matrix(random_goodness(rng, lengths, min_gap, density=0.4))
        found = max(
            finish(reconnect_steps(goodness, lengths, min_gap, cuts))[1]
            for cuts in cut_solutions(goodness, lengths, min_gap, 8, np.random.default_rng(0))
        )
        best = exhaustive_best(goodness, lengths, min_gap, kept_goodness)
        assert found <= best + 1e-9
        if best > 0:
            shares.append(found / best)
    assert len(shares) >= 15
    assert np.mean(shares) > 0.85
    assert np.mean(np.array(shares) > 1 - 1e-9) > 0.6


def test_greedy_cuts_are_worse():
    ours, theirs = 0.0, 0.0
    for seed in range(5):
        goodness, lengths, min_gap = random_problem(seed)
        solutions = cut_solutions(goodness, lengths, min_gap, 4, np.random.default_rng(0))
        greedy = greedy_cuts(goodness, lengths, min_gap)
        for frames in greedy:
            assert len(frames) != 1 and (np.diff(frames) >= min_gap).all()
        ours += max(finish(reconnect_steps(goodness, lengths, min_gap, cuts))[1] for cuts in solutions)
        theirs += kept_goodness(goodness, lengths, greedy)
        best = max(total_goodness(goodness, lengths, cuts) for cuts in solutions)
        assert best > total_goodness(goodness, lengths, greedy) > 0
    assert ours > theirs


def test_kept_goodness_leaves_out_what_cannot_be_returned_to():
    lengths = [7, 7]
    goodness = np.zeros((14, 14))
    goodness[3, 0] = goodness[0, 3] = 0.5  # the first half of the first clip is a loop
    goodness[3, 7] = goodness[7, 3] = 0.25  # and leads to the second clip, which nothing leads back from
    cuts = [np.array([0, 3, 6]), np.array([0, 6])]
    sparse = csr_matrix(goodness)
    assert total_goodness(sparse, lengths, cuts) == pytest.approx(0.5 + 0.25 + CONTINUATION)
    assert kept_goodness(sparse, lengths, cuts) == pytest.approx(0.5)


def test_the_same_seed_makes_the_same_cuts():
    goodness, lengths, min_gap = random_problem(7)
    runs = [cut_solutions(goodness, lengths, min_gap, 4, np.random.default_rng(3)) for _ in range(2)]
    for one, two in zip(*runs, strict=True):
        for a, b in zip(one, two, strict=True):
            np.testing.assert_array_equal(a, b)
    totals = [total_goodness(goodness, lengths, cuts) for cuts in runs[0]]
    assert len(set(np.round(totals, 6))) > 1  # other beginnings do lead elsewhere


def test_nothing_to_link_makes_no_cuts():
    (cuts,) = cut_solutions(csr_matrix((20, 20)), [8, 12], 30, 1, np.random.default_rng(0))
    assert [len(frames) for frames in cuts] == [0, 0]
    assert kept_goodness(csr_matrix((20, 20)), [8, 12], cuts) == 0
