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
def relax(
    low: int, high: int, free: Real, slope: float, decay: Real, line: Real, responses: Complex, at: int, z: Real
) -> None:
    """Relaxations at the nodes of a piece: free decay, line and sinusoids (rows of z from `at` on)."""
    for m in range(len(free)):
        start = free[m]
        for i in range(low, high):
            z[m, i] = start * decay[m, i] + slope * line[m, i]
        for k in range(responses.shape[1]):
            h = responses[m, k]
            for i in range(low, high):
                z[m, i] += h.real * z[at + 2 * k, i] - h.imag * z[at + 2 * k + 1, i]


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def states(
    offsets: Real, slopes: Real, amplitudes: Complex, first: NDArray[np.intp], since: Real, decay: Real, line: Real,
    spans: Real, end_decay: Real, end_line: Real, turns: Complex, responses: Complex, has_line: bool, has_slope: bool,
) -> Real:  # fmt: skip
    """States (n_states, n_nodes) of a circuit, in the order of `Circuit`.

    Arguments are those of `driven.plan_of`: per piece its first node; per node the time since its piece started, decay
    and line factor of each relaxation; per piece the same at its end; the turn of each sinusoid at each node and its
    response. Each inner loop runs over the nodes of a piece.
    """
    n_relax, n_turns = len(decay), turns.shape[1]
    slope_at = n_relax + (1 if has_line else 0)
    at = slope_at + (1 if has_slope else 0)
    z, free = np.empty((at + 2 * n_turns, len(since))), np.zeros(n_relax)
    for p in range(len(first) - 1):
        low, high, slope = first[p], first[p + 1], slopes[p]
        for k in range(n_turns):
            for i in range(low, high):
                turn = turns[i, k] * amplitudes[p, k]
                z[at + 2 * k, i], z[at + 2 * k + 1, i] = turn.real, turn.imag
        enter(p, low, offsets, slopes, amplitudes, turns, spans, end_decay, end_line, responses, free)
        relax(low, high, free, slope, decay, line, responses, at, z)
        if has_line:
            for i in range(low, high):
                z[n_relax, i] = offsets[p] + slope * since[i]
        if has_slope:
            z[slope_at, low:high] = slope
    return z


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def march(z: Real, newton: float, kinds: NDArray[np.intp], maps: Real, drives: Real) -> Real:
    """``x_(i+1) = map x_i + newton drive P(z_i)`` from 0, (n, n_nodes): P the products of z, upper triangle."""
    n, n_nodes = maps.shape[1], z.shape[1]
    path = np.zeros((n, n_nodes))
    for row in range(n):
        place = 0
        for a in range(len(z)):
            for b in range(a, len(z)):
                for i in range(n_nodes - 1):
                    path[row, i + 1] += newton * drives[kinds[i], row, place] * z[a, i] * z[b, i]
                place += 1
    for i in range(n_nodes - 1):
        for row in range(n):
            total = path[row, i + 1]
            for column in range(n):
                total += maps[kinds[i], row, column] * path[column, i]
            path[row, i + 1] = total
    return path


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def respond(
    newton: float, offsets: Real, slopes: Real, amplitudes: Complex, wanted: NDArray[np.intp],
    first: NDArray[np.intp], since: Real, decay: Real, line: Real, spans: Real, end_decay: Real, end_line: Real,
    turns: Complex, responses: Complex, has_line: bool, has_slope: bool, form: Real,
    kinds: NDArray[np.intp], maps: Real, drives: Real,
) -> Real:  # fmt: skip
    """Driven states (n, n_wanted) under the force ``newton u^2``, u the linear `form` of the circuit's states."""
    z = states(
        offsets, slopes, amplitudes, first, since, decay, line, spans, end_decay, end_line, turns, responses,
        has_line, has_slope,
    )  # fmt: skip
    path: Real = march(z, newton, kinds, maps, drives)
    return path[:, wanted]


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def slide(
    newton: float, mu: float, force_n: float, mass_kg: float, damping_n_s_per_m: float, stiffness_n_per_m: float,
    offsets: Real, slopes: Real, amplitudes: Complex, wanted: NDArray[np.intp],
    first: NDArray[np.intp], since: Real, decay: Real, line: Real, spans: Real, end_decay: Real, end_line: Real,
    turns: Complex, responses: Complex, has_line: bool, has_slope: bool, form: Real,
    kinds: NDArray[np.intp], maps: Real, drives: Real,
) -> Real:  # fmt: skip
    """Rows of `Motion`, (5, n_wanted): electrostatic and lateral force, deflection and its two derivatives."""
    z = states(
        offsets, slopes, amplitudes, first, since, decay, line, spans, end_decay, end_line, turns, responses,
        has_line, has_slope,
    )  # fmt: skip
    path, rows = march(z, mu * newton, kinds, maps, drives), np.empty((5, len(wanted)))
    for j in range(len(wanted)):
        i, output = wanted[j], 0.0
        for q in range(len(form)):
            output += form[q] * z[q, i]
        attraction, x, speed = newton * output * output, path[0, i], path[1, i]
        rows[0, j], rows[1, j] = attraction, mu * force_n + mu * attraction
        rows[2, j], rows[3, j] = mu * force_n / stiffness_n_per_m + x, speed
        rows[4, j] = (mu * attraction - damping_n_s_per_m * speed - stiffness_n_per_m * x) / mass_kg
    return rows


@compiled  # type: ignore[untyped-decorator]  # pragma: no cover
def slide_many(
    newton: float, mu: float, force_n: float, mass_kg: float, damping_n_s_per_m: float, stiffness_n_per_m: float,
    offsets: Real, slopes: Real, amplitudes: Complex, wanted: NDArray[np.intp],
    first: NDArray[np.intp], since: Real, decay: Real, line: Real, spans: Real, end_decay: Real, end_line: Real,
    turns: Complex, responses: Complex, has_line: bool, has_slope: bool, form: Real,
    kinds: NDArray[np.intp], maps: Real, drives: Real,
) -> Real:  # fmt: skip
    """`slide` for heights with a first axis (n_stimuli,): (5, n_stimuli, n_wanted)."""
    rows = np.empty((5, len(offsets), len(wanted)))
    for s in range(len(offsets)):
        rows[:, s] = slide(
            newton, mu, force_n, mass_kg, damping_n_s_per_m, stiffness_n_per_m, offsets[s], slopes[s], amplitudes[s],
            wanted, first, since, decay, line, spans, end_decay, end_line, turns, responses, has_line, has_slope, form,
            kinds, maps, drives,
        )  # fmt: skip
    return rows
