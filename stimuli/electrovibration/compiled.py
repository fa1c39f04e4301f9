"""Loops that must be loops, compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
compiled: Any = njit(cache=True)


@compiled  # type: ignore[untyped-decorator]
def _turned(turns: Complex, amplitudes: Complex) -> float:
    total = 0.0
    for k in range(len(turns)):
        total += (turns[k] * amplitudes[k]).real
    return total


@compiled  # type: ignore[untyped-decorator]
def _enter(
    new: int, offsets: Real, slopes: Real, amplitudes: Complex, turns: Complex,
    spans: Real, end_decay: Real, end_line: Real, responses: Complex, free: Real,
) -> None:  # fmt: skip
    """Free decays at the start of a piece, from those of the piece before it and the jump between them."""
    old, jump = new - 1, offsets[new] + _turned(turns, amplitudes[new])
    if old >= 0:
        jump -= offsets[old] + slopes[old] * spans[old] + _turned(turns, amplitudes[old])
    for m in range(len(free)):
        turned = turns * responses[m]
        if old >= 0:
            free[m] = free[m] * end_decay[m, old] + slopes[old] * end_line[m, old] + _turned(turned, amplitudes[old])
        free[m] += jump - _turned(turned, amplitudes[new])


@compiled  # type: ignore[untyped-decorator]
def _advance(step: Real, drive: Real, newton: float, x: Real, z: Real, after: Real) -> None:
    """``after = step x + newton drive P(z)``, P the products of z in the order of the upper triangle."""
    for row in range(len(x)):
        total, product = 0.0, 0
        for a in range(len(z)):
            for b in range(a, len(z)):
                total += drive[row, product] * z[a] * z[b]
                product += 1
        after[row] = newton * total
        for column in range(len(x)):
            after[row] += step[row, column] * x[column]


@compiled  # type: ignore[untyped-decorator]
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
    voltage, path = np.empty(n_nodes), np.zeros((n_nodes, maps.shape[1]))
    has_line = dc_gain != 0
    slope_at = n_relax + (1 if has_line else 0)
    first = slope_at + (1 if has_slope else 0)
    free, z = np.zeros(n_relax), np.zeros(first + 2 * n_turns)
    held = -1
    for i in range(n_nodes):
        now = piece[i]
        while held < now:
            held += 1
            _enter(held, offsets, slopes, amplitudes, turns[i], spans, end_decay, end_line, responses, free)
        level = offsets[now] + slopes[now] * since[i]
        for m in range(n_relax):
            z[m] = free[m] * decay[m, i] + slopes[now] * line[m, i] + _turned(turns[i] * responses[m], amplitudes[now])
        if has_line:
            z[n_relax] = level
        if has_slope:
            z[slope_at] = slopes[now]
        for k in range(n_turns):
            turn = turns[i, k] * amplitudes[now, k]
            z[first + 2 * k], z[first + 2 * k + 1] = turn.real, turn.imag
        voltage[i] = dc_gain * (level + _turned(turns[i], amplitudes[now])) + np.sum(gains * z[:n_relax])
        if i + 1 < n_nodes:
            _advance(maps[kinds[i]], drives[kinds[i]], newton, path[i], z, path[i + 1])
    return voltage, path
