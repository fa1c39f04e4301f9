"""Blocks in batches: each track is its rule's own run, and turns and catch trials are as often as a session's."""

import itertools

import numpy as np
import pytest
from batches import LEVELS, OUTPUT, own_run
from hypothesis import given, strategies as st
from scipy.stats import chisquare

from tactometry.errors import InvalidParameter
from tactometry.protocols import ConstantStimuli, Staircase
from tactometry.protocols.batch.answers import LevelTable
from tactometry.protocols.batch.blocks import blocks
from tactometry.protocols.batch.delivery import AS_ASKED
from tactometry.protocols.batch.turns import CATCH, NOBODY, catch_trials, order_of
from tactometry.protocols.block_state import catch_schedule, turns

RULE = Staircase(20.0, (6.0, 3.0), 0.0, 40.0, n_down=1, n_reversals=4, n_trials=12)
INTERLEAVINGS = ["random", "balanced"]
N = 20_000


def orders_of_a_session(lengths, interleaving, rng):
    """Whose presentations follow each other in one block."""
    turn, left, order = turns(interleaving, rng), list(lengths), []
    while open_ := [n for n, more in enumerate(left) if more]:
        order.append(turn(open_))
        left[order[-1]] -= 1
    return tuple(order)


def chances(lengths, interleaving):
    """Of every order of a block, by going through all that a turn may draw."""
    if interleaving == "balanced":
        rounds = [[n for n, more in enumerate(lengths) if more > done] for done in range(max(lengths))]
        ways = itertools.product(*(itertools.permutations(each) for each in rounds))
        orders = [tuple(itertools.chain(*way)) for way in ways]
        return dict.fromkeys(orders, 1 / len(orders))
    open_ = [n for n, more in enumerate(lengths) if more]
    if not open_:
        return {(): 1.0}
    found = {}
    for first in open_:
        rest = [more - (n == first) for n, more in enumerate(lengths)]
        for order, chance in chances(rest, interleaving).items():
            found[first, *order] = chance / len(open_)
    return found


@pytest.mark.parametrize("interleaving", INTERLEAVINGS)
def test_each_order_of_a_block_is_as_likely_as_in_a_session(interleaving):
    lengths, rng = (2, 1, 2), np.random.default_rng()
    expected = chances(lengths, interleaving)
    in_batch = map(tuple, order_of(np.tile(lengths, (N, 1)), interleaving, rng).tolist())
    in_sessions = [orders_of_a_session(lengths, interleaving, rng) for _ in range(N)]
    for found in (list(in_batch), in_sessions):
        assert set(found) <= set(expected)
        counts = [found.count(order) for order in expected]
        assert chisquare(counts, N * np.array(list(expected.values()))).pvalue > 1e-4


def test_catch_trials_are_where_those_of_a_session_are():
    rng = np.random.default_rng()
    in_batch = catch_trials((N,), 6, 0.3, rng)[:, :6] @ 2 ** np.arange(6)
    schedules = [list(itertools.islice(catch_schedule(0.3, rng), 6)) for _ in range(N)]
    in_sessions = np.array(schedules) @ 2 ** np.arange(6)
    for found in (in_batch, in_sessions):  # one of each group of three
        counts = np.bincount(found, minlength=64)
        places = [2**first + 2**second for first in range(3) for second in range(3, 6)]
        assert counts.sum() == counts[places].sum()
        assert chisquare(counts[places]).pvalue > 1e-4


@given(
    seed=st.integers(0, 2**32 - 1),
    interleaving=st.sampled_from(INTERLEAVINGS),
    catch_rate=st.sampled_from([0.0, 0.2, 0.5]),
    output=st.sampled_from([AS_ASKED, OUTPUT]),
)
def test_tracks_of_a_block_are_their_own_runs_and_all_their_trials_are_presented(
    seed, interleaving, catch_rate, output
):
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(0, 40) + 4 * rng.standard_normal((4, 3, 15))
    tables = [LevelTable(LEVELS, np.sort(rng.uniform(0, 40, (4, len(LEVELS))))) for _ in range(3)]
    made = blocks(RULE, drawn, rng, tables=tables, interleaving=interleaving, catch_rate=catch_rate, delivery=output)
    for track, (batch, table) in enumerate(zip(made.tracks, tables, strict=True)):
        for i, n in enumerate(batch.n_trials):
            levels, run = own_run(RULE, (), batch.answers[i, :n], output)
            assert (batch.asked[i, :n].tolist(), batch.ending(i)) == (levels, run.ending)
            felt = np.interp(output(np.array(levels)), LEVELS, table.felt[i])
            assert np.array_equal(batch.answers[i, :n], felt > drawn[i, track, :n])
            trials = made.trials[i, made.turns[i] == track]
            assert trials[trials != CATCH].tolist() == list(range(n))
            assert trials[-1] == n - 1  # no catch trial after the last answer
    assert (made.trials[made.turns == NOBODY] == CATCH).all()


@pytest.mark.parametrize("catch_rate", [0.1, 0.5])
def test_a_block_of_one_track_has_the_catch_trials_of_its_rate(catch_rate):
    made = blocks(ConstantStimuli((1.0, 2.0), 20), np.zeros((5, 1, 40)), np.random.default_rng(), catch_rate=catch_rate)
    n_catch = (made.trials == CATCH).sum(axis=1) - (made.turns == NOBODY).sum(axis=1)
    share = n_catch / (n_catch + 40)
    assert np.abs(share - catch_rate).max() < 1 / 40


def test_every_track_of_constant_stimuli_has_an_order_of_its_own():
    made = blocks(ConstantStimuli(tuple(map(float, range(30))), 1), np.zeros((2, 2, 30)), np.random.default_rng())
    orders = {tuple(levels) for track in made.tracks for levels in track.levels.tolist()}
    assert len(orders) == 4


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"criteria": np.zeros((3, 4))}, r"tracks.criteria: .* expected \(n_sets, n_tracks, n_trials\)"),
        ({"tables": [LevelTable(LEVELS, LEVELS)]}, "blocks.tables: found 1 tables, expected 2"),
        ({"interleaving": "alternating"}, "BlockOptions.interleaving: found 'alternating'"),
        ({"catch_rate": 0.9}, "BlockOptions.catch_rate"),
    ],
)
def test_what_is_no_block_is_refused(changed, sentence):
    given_ = {"criteria": np.zeros((2, 2, 4)), **changed}
    with pytest.raises(InvalidParameter, match=sentence):
        blocks(RULE, given_.pop("criteria"), np.random.default_rng(), **given_)
