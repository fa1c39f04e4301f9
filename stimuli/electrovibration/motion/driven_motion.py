"""Motion of a linear system under the force of a voltage in pieces: planned once, then run for any voltage.

A relaxation that has decayed (`phases.DECAYED` time constants after the start of a piece) follows its input and is left
out of the lift, which bounds every exponent.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments import require
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray, IndexArray
from ..attraction.force import ForceForm
from ..skin.relaxation import Relaxations
from ..waveforms.pieces import Pieces
from .lift import Circuit, LinearSystem, flow, pairs
from .phases import Heights, heights, moving, nodes_of, phases

if TYPE_CHECKING:
    from .compiled_loops import DrivenPlan

Kind = tuple[float, tuple[bool, ...]]
"""Length of an interval and which relaxations move in it."""
CYCLES_MAX = 1e7
"""The most periods of a lag or a finger between two times: rounding is 1e-9 of the largest force there."""


def linear_response(pieces: Pieces, form: ForceForm, system: LinearSystem, t_s: ArrayLike) -> FloatArray:
    """States (n, n_times) of a linear system from 0 under the force of a voltage, exactly, at ascending times."""
    from .compiled_loops import respond

    plan = plan_of(Timing(pieces, t_s), form.relaxations, system)
    return respond(form.newton_per_v2, heights(pieces), plan)


def stack_heights(stimuli: Sequence[Pieces]) -> Heights:
    """Heights with a first axis (n_stimuli,), of stimuli whose pieces start at the same times.

    Raises
    ------
    InvalidParameter
        If there is no stimulus, or one has other starts, frequencies or an other end than the first.
    """
    require.expect(len(stimuli) > 0, "stimuli", stimuli, "a sequence of at least one voltage in pieces")
    key = Timing(stimuli[0], np.zeros(0), has_slope=True)
    for place, pieces in enumerate(stimuli):
        difference = "other starts, frequencies or an other end than the first stimulus has"
        same = Timing(pieces, key.t_s, has_slope=True) == key
        require.expect(same, f"stimuli[{place}]", difference, "the same; solve it by itself")
    return Heights(*map(np.array, zip(*map(heights, stimuli), strict=True)))


def check_times(t: FloatArray, pieces: Pieces) -> None:
    """Refuse times (n_times,) that do not ascend from at least 0 to at most the end of the pieces."""
    require.finite_array("t_s", t)
    inside = t.ndim == 1 and t.size > 0 and t[0] >= 0 and t[-1] <= pieces.end_s and (np.diff(t) > 0).all()
    found = f"{t.size} times in shape {t.shape}"
    require.expect(inside, "t_s", found, f"ascending times from 0 to {pieces.end_s} s")


class Timing:
    """When pieces start and which times are asked for: what a plan depends on, but for the heights."""

    def __init__(self, pieces: Pieces, t_s: ArrayLike, *, has_slope: bool | None = None) -> None:
        self.pieces, self.t_s = pieces, np.asarray(t_s, dtype=np.float64)
        self.has_slope = bool(np.count_nonzero(pieces.slopes_v_per_s)) if has_slope is None else has_slope
        self._key = (
            self.has_slope, pieces.end_s, pieces.starts_s.tobytes(), pieces.frequencies_hz.tobytes(),
            self.t_s.shape, self.t_s.tobytes(),
        )  # fmt: skip

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Timing) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


@lru_cache(maxsize=256)
def plan_of(timing: Timing, relaxations: Relaxations, system: LinearSystem) -> "DrivenPlan":
    """The plan of a timing, made once: nodes, decays, turns and exponentials."""
    from .compiled_loops import DrivenPlan

    check_times(timing.t_s, timing.pieces)
    nodes = nodes_of(timing.pieces, relaxations, timing.t_s)
    lengths = np.diff(nodes)
    _check_resolved(system, float(lengths.max(initial=0.0)))
    shared = phases(timing.pieces, relaxations, nodes)
    groups, kinds = _kinds(lengths, moving(shared.since, relaxations)[:-1])
    first = np.searchsorted(shared.piece, np.arange(shared.piece[-1] + 2))  # node of each piece, and the end
    all_moving = (True,) * len(relaxations.rates_per_s)
    whole = Circuit(relaxations, tuple(timing.pieces.frequencies_hz.tolist()), timing.has_slope, all_moving)
    maps, drives = _maps(whole, system, groups)
    wanted = np.searchsorted(nodes, timing.t_s)
    return DrivenPlan(shared, wanted, first, whole.has_line, whole.has_slope, whole.output(), kinds, maps, drives)


def _check_resolved(system: LinearSystem, longest_s: float) -> None:
    fastest_hz = float(np.abs(np.linalg.eigvals(system.matrix)).max()) / (2 * np.pi)
    if not fastest_hz * longest_s <= CYCLES_MAX * (1 + 1e-9):
        raise InvalidParameter(
            f"finger: found one that moves at up to {fastest_hz:.3g} Hz with times up to {longest_s:.3g} s apart, "
            f"expected a product of at most {CYCLES_MAX:.0e}; take a heavier, softer or less damped finger"
        )


def _maps(whole: Circuit, system: LinearSystem, groups: Sequence[Kind]) -> tuple[FloatArray, FloatArray]:
    """(n_kinds, n, n) maps of the states and (n_kinds, n, n_products) of the products over each kind of interval."""
    from threadpoolctl import threadpool_limits

    circuits = [replace(whole, active=moving) for _, moving in groups]
    with threadpool_limits(1, "blas"):  # threads that wait for each other over small matrices took 20 times as long
        flows = [flow(circuit, system, length) for circuit, (length, _) in zip(circuits, groups, strict=True)]
    n = len(system.input)
    maps = np.array([step.states for step in flows]).reshape(-1, n, n)
    drives = np.array([_padded(step.products, circuit) for step, circuit in zip(flows, circuits, strict=True)])
    return maps, drives.reshape(len(flows), n, -1)


def _kinds(lengths: FloatArray, moves: NDArray[np.bool_]) -> tuple[list[Kind], IndexArray]:
    """Intervals of one length (to 1e-11) and one set of moving relaxations share an exponential."""
    # equal steps of time differ by their rounding: digits behind the leading one, and its power of ten
    scale = 10.0 ** np.floor(np.log10(lengths))
    keys = np.column_stack([np.round(lengths / scale, 11), scale, moves])
    _, first, kinds = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    means = np.bincount(kinds, lengths) / np.bincount(kinds)
    return [(float(means[k]), tuple(moves[i].tolist())) for k, i in enumerate(first)], kinds


def _padded(products: FloatArray, circuit: Circuit) -> FloatArray:
    """The map of the products (n, n_products) among those of all states, 0 for the relaxations left out."""
    kept = circuit.active_places()
    n_all = circuit.n_states + circuit.active.count(False)
    i, j = pairs(n_all)
    here = np.isin(i, kept) & np.isin(j, kept)
    full = np.zeros((products.shape[0], i.size))
    full[:, here] = products
    return full
