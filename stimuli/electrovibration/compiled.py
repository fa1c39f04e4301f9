"""Loops that must be loops, compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
compiled: Any = njit(cache=True)


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def turned(turns: Complex, i: int, amplitudes: Complex, piece: int) -> float:
    """The sinusoids of a piece at node i."""
    total = 0.0
    for k in range(turns.shape[1]):
        total += (turns[i, k] * amplitudes[piece, k]).real
    return total


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def answered(turns: Complex, i: int, responses: Complex, m: int, amplitudes: Complex, piece: int) -> float:
    """What relaxation m makes of the sinusoids of a piece at node i."""
    total = 0.0
    for k in range(turns.shape[1]):
        total += (turns[i, k] * responses[m, k] * amplitudes[piece, k]).real
    return total


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def enter(
    new: int, i: int, offsets: Real, slopes: Real, amplitudes: Complex, turns: Complex,
    spans: Real, end_decay: Real, end_line: Real, responses: Complex, free: Real,
) -> None:  # fmt: skip
    """Free decays at the start of a piece (node i), from those of the piece before it and the jump between them."""
    old, jump = new - 1, offsets[new] + turned(turns, i, amplitudes, new)
    if old >= 0:
        jump -= offsets[old] + slopes[old] * spans[old] + turned(turns, i, amplitudes, old)
    for m in range(len(free)):
        if old >= 0:
            free[m] = free[m] * end_decay[m, old] + slopes[old] * end_line[m, old]
            free[m] += answered(turns, i, responses, m, amplitudes, old)
        free[m] += jump - answered(turns, i, responses, m, amplitudes, new)


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def _advance(maps: Real, drives: Real, kind: int, newton: float, path: Real, i: int, z: Real, squares: Real) -> None:
    """``x_(i+1) = map x_i + newton drive P(z)``, P the products of z in the order of the upper triangle."""
    place = 0
    for a in range(len(z)):
        for b in range(a, len(z)):
            squares[place] = newton * z[a] * z[b]
            place += 1
    for row in range(path.shape[1]):
        total = 0.0
        for q in range(len(squares)):
            total += drives[kind, row, q] * squares[q]
        for column in range(path.shape[1]):
            total += maps[kind, row, column] * path[i, column]
        path[i + 1, row] = total


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def respond(
    offsets: Real, slopes: Real, amplitudes: Complex, newton: float,
    piece: NDArray[np.intp], since: Real, decay: Real, line: Real, spans: Real, end_decay: Real, end_line: Real,
    turns: Complex, responses: Complex, gains: Real, dc_gain: float, has_slope: bool,
    kinds: NDArray[np.intp], maps: Real, drives: Real,
) -> tuple[Real, Real]:  # fmt: skip
    """Voltage (n_nodes,) and driven states (n_nodes, n) at the nodes of a plan.

    Arguments are those of `driven._plan`: per node the piece that holds, the time since its start, decay and line
    factor of each relaxation; per piece the same at its end; the turn of each sinusoid at each node and its response.
    """
    n_nodes, n_relax, n_turns = len(piece), len(gains), amplitudes.shape[1]
    voltage, path = np.zeros(n_nodes), np.zeros((n_nodes, maps.shape[1]))
    has_line = dc_gain != 0
    slope_at = n_relax + (1 if has_line else 0)
    first = slope_at + (1 if has_slope else 0)
    free, z, squares = np.zeros(n_relax), np.zeros(first + 2 * n_turns), np.zeros(drives.shape[2])
    held = -1
    for i in range(n_nodes):
        now = piece[i]
        while held < now:
            held += 1
            enter(held, i, offsets, slopes, amplitudes, turns, spans, end_decay, end_line, responses, free)
        level, total = offsets[now] + slopes[now] * since[i], 0.0
        for m in range(n_relax):
            y = free[m] * decay[m, i] + slopes[now] * line[m, i] + answered(turns, i, responses, m, amplitudes, now)
            z[m] = y
            total += gains[m] * y
        if has_line:
            z[n_relax] = level
        if has_slope:
            z[slope_at] = slopes[now]
        for k in range(n_turns):
            turn = turns[i, k] * amplitudes[now, k]
            z[first + 2 * k], z[first + 2 * k + 1] = turn.real, turn.imag
        voltage[i] = total + dc_gain * (level + turned(turns, i, amplitudes, now))
        if i + 1 < n_nodes:
            _advance(maps, drives, kinds[i], newton, path, i, z, squares)
    return voltage, path


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def respond_many(
    offsets: Real, slopes: Real, amplitudes: Complex, newton: float,
    piece: NDArray[np.intp], since: Real, decay: Real, line: Real, spans: Real, end_decay: Real, end_line: Real,
    turns: Complex, responses: Complex, gains: Real, dc_gain: float, has_slope: bool,
    kinds: NDArray[np.intp], maps: Real, drives: Real,
) -> tuple[Real, Real]:  # fmt: skip
    """`respond` for heights with a first axis (n_stimuli,)."""
    n_stimuli, n_nodes = len(offsets), len(piece)
    voltages, paths = np.empty((n_stimuli, n_nodes)), np.empty((n_stimuli, n_nodes, maps.shape[1]))
    for s in range(n_stimuli):
        voltages[s], paths[s] = respond(
            offsets[s], slopes[s], amplitudes[s], newton, piece, since, decay, line, spans, end_decay, end_line,
            turns, responses, gains, dc_gain, has_slope, kinds, maps, drives,
        )  # fmt: skip
    return voltages, paths
