"""Compiled loops over nodes that cannot be vectorised."""

from typing import Any, NamedTuple

import numpy as np

from tactometry.compiled import compiled, entry, uniform

from ...arrays import FloatArray
from .driven_motion import DrivenPlan
from .phases import Heights, Phases

Bare = tuple[Any, ...]


class FullSlip(NamedTuple):
    """A finger in full slip: its pad, its coefficient of friction and its normal force."""

    mass_kg: float
    damping_n_s_per_m: float
    stiffness_n_per_m: float
    coefficient: float
    force_n: float


@compiled
def sinusoids_at(i: int, piece: int, heights: Heights, phases: Phases) -> float:
    """Return the sum of a piece's sinusoids at node i."""
    total = 0.0
    for k in range(phases.turns.shape[1]):
        total += (phases.turns[i, k] * heights.amplitudes[piece, k]).real
    return total


@compiled
def response_at(m: int, i: int, piece: int, heights: Heights, phases: Phases) -> float:
    """Return the response of relaxation m to a piece's sinusoids at node i."""
    total = 0.0
    for k in range(phases.turns.shape[1]):
        total += (phases.turns[i, k] * phases.responses[m, k] * heights.amplitudes[piece, k]).real
    return total


@compiled
def enter(new: int, i: int, heights: Heights, phases: Phases, free: FloatArray) -> None:
    """Update the free decays in place at the start of a piece (node i)."""
    old, jump = new - 1, heights.offsets[new] + sinusoids_at(i, new, heights, phases)
    if old >= 0:
        jump -= heights.offsets[old] + heights.slopes[old] * phases.spans[old] + sinusoids_at(i, old, heights, phases)
    for m in range(len(free)):
        if old >= 0:
            free[m] = free[m] * phases.end_decay[m, old] + heights.slopes[old] * phases.end_line[m, old]
            free[m] += response_at(m, i, old, heights, phases)
        free[m] += jump - response_at(m, i, new, heights, phases)


@compiled
def relax(low: int, high: int, slope: float, phases: Phases, at: int, free: FloatArray, z: FloatArray) -> None:
    """Write a piece's relaxations to z, whose sinusoids start at row `at`."""
    for m in range(len(free)):
        start = free[m]
        for i in range(low, high):
            z[m, i] = start * phases.decay[m, i] + slope * phases.line[m, i]
        for k in range(phases.responses.shape[1]):
            h = phases.responses[m, k]
            for i in range(low, high):
                z[m, i] += h.real * z[at + 2 * k, i] - h.imag * z[at + 2 * k + 1, i]


@compiled
def states(heights: Heights, plan: DrivenPlan) -> FloatArray:
    """Return the states of a circuit in the order of `Circuit`, (n, n_nodes)."""
    phases, first = plan.phases, plan.first
    n_relax, n_turns = len(phases.decay), phases.turns.shape[1]
    slope_at = n_relax + (1 if plan.has_line else 0)
    at = slope_at + (1 if plan.has_slope else 0)
    z, free = np.empty((at + 2 * n_turns, len(phases.since))), np.zeros(n_relax)
    for p in range(len(first) - 1):
        low, high, slope = first[p], first[p + 1], heights.slopes[p]
        for k in range(n_turns):
            for i in range(low, high):
                turn = phases.turns[i, k] * heights.amplitudes[p, k]
                z[at + 2 * k, i], z[at + 2 * k + 1, i] = turn.real, turn.imag
        enter(p, low, heights, phases, free)
        relax(low, high, slope, phases, at, free, z)
        if plan.has_line:
            for i in range(low, high):
                z[n_relax, i] = heights.offsets[p] + slope * phases.since[i]
        if plan.has_slope:
            z[slope_at, low:high] = slope
    return z


@compiled
def march(z: FloatArray, newton: float, plan: DrivenPlan) -> FloatArray:
    """Return x (n, n_nodes) of ``x_(i+1) = map x_i + newton z_i drive z_i``."""
    kinds, maps, drives = plan.kinds, plan.maps, plan.drives
    n, n_nodes = maps.shape[1], z.shape[1]
    path = np.zeros((n, n_nodes))
    for row in range(n):
        for a in range(len(z)):
            for b in range(a, len(z)):
                factor = newton if a == b else 2 * newton  # the forms are symmetric
                for i in range(n_nodes - 1):
                    path[row, i + 1] += factor * drives[kinds[i], row, a, b] * z[a, i] * z[b, i]
    for i in range(n_nodes - 1):
        for row in range(n):
            total = path[row, i + 1]
            for column in range(n):
                total += maps[kinds[i], row, column] * path[column, i]
            path[row, i + 1] = total
    return path


def slide(newton: float, finger: FullSlip, heights: Heights, plan: DrivenPlan) -> FloatArray:
    """Return the rows of `Motion`, (5, n_wanted)."""
    return _slide(newton, uniform(finger), uniform(heights), (tuple(plan.phases), *plan[1:]))


@entry
def _slide(newton: float, finger: Bare, heights: Bare, plan: Bare) -> FloatArray:
    whole = DrivenPlan(Phases(*plan[0]), *plan[1:])
    return _slip(newton, FullSlip(*finger), Heights(*heights), whole)


@compiled
def _slip(newton: float, finger: FullSlip, heights: Heights, plan: DrivenPlan) -> FloatArray:
    m, c, k, mu, force_n = finger
    z = states(heights, plan)
    path, rows = march(z, mu * newton, plan), np.empty((5, len(plan.wanted)))
    for j in range(len(plan.wanted)):
        i, output = plan.wanted[j], 0.0
        for q in range(len(plan.form)):
            output += plan.form[q] * z[q, i]
        attraction, x, speed = newton * output * output, path[0, i], path[1, i]
        rows[0, j], rows[1, j] = attraction, mu * force_n + mu * attraction
        rows[2, j], rows[3, j] = mu * force_n / k + x, speed
        rows[4, j] = (mu * attraction - c * speed - k * x) / m
    return rows
