"""Time the motion of skin and finger, compared with `solve_ivp` and compiled RK4.

    OMP_NUM_THREADS=1 python benchmarks/electrovibration.py

Signals of 50 ms with 288 outputs are computed, with one tau per row. For each solver, the loosest setting with an error
below 1e-3 of the largest deflection counts. Solvers restart at every kink of the voltage, with a plain and a compiled
right-hand side. The reference solves the mechanical equation with the closed-form force at 1e-12. Accuracy problems
cover stick-slip motion.
"""

from collections.abc import Callable, Iterable
from itertools import pairwise, product
from statistics import median
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tactometry.experiments.harness import interleaved, run_once, tell
from tactometry.stimuli.electrovibration import CoulombFriction, Finger, Sine, Skin, Step, Trapezoid
from tactometry.stimuli.electrovibration.attraction.force import ForceForm, force_form
from tactometry.stimuli.electrovibration.motion.driven_motion import plan_of
from tactometry.stimuli.electrovibration.motion.finger import sliding
from tactometry.stimuli.electrovibration.skin.relaxation import Solution
from tactometry.stimuli.electrovibration.waveforms.pieces import Pieces

Real = NDArray[np.float64]
Solver = Callable[[Pieces, ForceForm], Real]
FINGER, MU, END_S = Finger(), 0.5, 0.05
T_S = np.linspace(0, END_S, 289)[1:]
INPUTS = {
    "step": Step(duration_s=END_S).pieces(40.0),
    "trapezoid": Trapezoid(rise_s=1e-3, high_s=8e-3, fall_s=1e-3, low_s=8e-3, duration_s=END_S).pieces(40.0),
    "sine": Sine(frequency_hz=240.0, ramp_s=0.0, duration_s=END_S).pieces(40.0),
}
TAUS_S = (1e-6, 1e-4, 5e-3, 1.0)
TOLERANCES = tuple(float(f"{r:.1g}") for r in np.geomspace(1e-2, 1e-8, 13))
METHODS, EXPLICIT = ("LSODA", "RK45", "RK23", "DOP853", "Radau", "BDF"), ("RK45", "RK23", "DOP853")


@njit(cache=True)  # type: ignore[untyped-decorator]
def rhs(t: float, y: Real, p: Real) -> Real:
    """Return (V_c', x', v') with the capacitor's voltage V_c, where V_sc = k (V - V_c).

    `p` contains the parameters of the voltage piece and of the equations.
    """
    voltage = p[0] + p[1] * (t - p[2]) + p[3] * np.cos(p[4] * t) - p[5] * np.sin(p[4] * t)
    layer = voltage - y[0]
    out = np.empty(3)
    out[0] = p[6] * layer
    out[1] = y[2]
    out[2] = p[7] * layer * layer - p[8] * y[2] - p[9] * y[1]
    return out


@njit(cache=True)  # type: ignore[untyped-decorator]
def rk4(y: Real, start: float, stop: float, n_steps: int, p: Real, at: Real) -> tuple[Real, Real]:
    """Take equal steps, and return deflections at `at` (cubic interpolation) and the last state."""
    h, result, here = (stop - start) / n_steps, np.empty(len(at)), 0
    for i in range(n_steps):
        t = start + i * h
        a = rhs(t, y, p)
        b = rhs(t + h / 2, y + h / 2 * a, p)
        c = rhs(t + h / 2, y + h / 2 * b, p)
        d = rhs(t + h, y + h * c, p)
        after = y + h / 6 * (a + 2 * b + 2 * c + d)
        while here < len(at) and (at[here] <= t + h or i == n_steps - 1):
            u = (at[here] - t) / h
            jump = after[1] - y[1]
            curve = u * (1 - u) * ((1 - u) * (h * y[2] - jump) - u * (h * after[2] - jump))
            result[here] = y[1] + u * jump + curve
            here += 1
        y = after
    return result, y


def parameters(pieces: Pieces, form: ForceForm, piece: int) -> Real:
    gain, rate, m = form.relaxations.gains[0], form.relaxations.rates_per_s[0], FINGER.mass_kg
    is_tone = bool(pieces.frequencies_hz.size)
    c = pieces.harmonics_v[piece, 0] if is_tone else 0j
    omega = 2 * np.pi * pieces.frequencies_hz[0] if is_tone else 0.0
    voltage = [pieces.offsets_v[piece], pieces.slopes_v_per_s[piece], pieces.starts_s[piece], c.real, omega, c.imag]
    force = MU * form.newton_per_v2 * gain**2 / m
    return np.array([*voltage, rate, force, FINGER.damping_n_s_per_m / m, FINGER.stiffness_n_per_m / m])


def over_pieces(leg: Callable[[Real, float, float, Real, Real], tuple[Real, Real]]) -> Solver:
    """Return a solver for the deflections at `T_S`, which restarts at each piece."""

    def solve(pieces: Pieces, form: ForceForm) -> Real:
        y, result = np.zeros(3), []
        for i, (start, stop) in enumerate(pairwise([*pieces.starts_s, pieces.end_s])):
            at = T_S[(start < T_S) & (stop >= T_S)]
            part, y = leg(y, start, stop, parameters(pieces, form, i), at)
            result.append(part)
        return np.concatenate(result)

    return solve


def adaptive(method: str, tolerance: float, slope: Callable[..., Any]) -> Solver:
    scale = {"rtol": tolerance, "atol": [tolerance * 100, tolerance * 1e-9, tolerance * 1e-7]}

    def leg(y: Real, start: float, stop: float, p: Real, at: Real) -> tuple[Real, Real]:
        r = solve_ivp(slope, (start, stop), y, method=method, t_eval=np.r_[at[at < stop], stop], args=(p,), **scale)
        return (r.y[1, : len(at)], r.y[:, -1]) if r.success else (np.full(len(at), np.nan), np.full(3, np.nan))

    return over_pieces(leg)


def stepped(n_per_second: float) -> Solver:
    return over_pieces(
        lambda y, start, stop, p, at: rk4(y, start, stop, max(1, round((stop - start) * n_per_second)), p, at)
    )


def exact(pieces: Pieces, form: ForceForm) -> Real:
    return sliding(T_S, pieces, form, finger=FINGER, friction=CoulombFriction(MU), force_n=1e-30).deflection_m


def reference(pieces: Pieces, form: ForceForm) -> Real:
    solved, tau_s = Solution(pieces, form.relaxations), 1 / form.relaxations.rates_per_s[0]
    m, c, k = FINGER.mass_kg, FINGER.damping_n_s_per_m, FINGER.stiffness_n_per_m
    starts = np.array([x for s in pieces.starts_s for x in (s, s + 3 * tau_s, s + 40 * tau_s) if x < pieces.end_s])
    y, result = np.zeros(2), []
    for start, stop in pairwise(np.unique(np.r_[starts, pieces.end_s])):
        inner = np.nextafter(stop, 0)

        def slope(t: float, y: Real, inner: float = inner) -> list[float]:
            push = MU * form.newton_per_v2 * float(solved.at(min(t, inner))) ** 2
            return [y[1], (push - c * y[1] - k * y[0]) / m]

        at = T_S[(start < T_S) & (stop >= T_S)]
        options = {
            "t_eval": np.r_[at[at < stop], stop],
            "rtol": 1e-12,
            "atol": 1e-22,
            "first_step": (stop - start) / 50,
        }
        r = solve_ivp(slope, (start, stop), y, method="DOP853", **options)
        y = r.y[:, -1]
        result.append(r.y[0, : len(at)])
    return np.concatenate(result)


def loosest_s(solvers: Iterable[Solver], pieces: Pieces, form: ForceForm, truth: Real, goal: float) -> float:
    """Return the median time of the loosest solver that reaches an error, or NaN."""
    for solver in solvers:
        with np.errstate(all="ignore"):
            error = np.abs(solver(pieces, form) - truth).max() / np.abs(truth).max()
        if error <= goal:
            return median(interleaved({"peer": lambda s=solver: s(pieces, form)}, 5)["peer"])
    return np.nan


def motion() -> None:
    ratios: dict[str, list[float]] = {}
    slopes, steppers = {"compiled": rhs, "plain": rhs.py_func}, [stepped(n) for n in np.geomspace(1e3, 1e8, 21)]
    for tau_s, (name, pieces) in product(TAUS_S, INPUTS.items()):
        form = force_form("sc_layer", Skin(corneum_resistivity_ohm_m=2e4 * tau_s / Skin().tau_s), 1e-4)
        truth, row = reference(pieces, form), {}
        plan_of.cache_clear()
        cold_s, _ = run_once(lambda: exact(pieces, form))  # noqa: B023
        warm_s = median(interleaved({"exact": lambda: exact(pieces, form)}, 51)["exact"])  # noqa: B023
        methods = [method for method in METHODS if method not in EXPLICIT or tau_s >= 1e-5]  # else 1e5 steps
        for kind, slope in slopes.items():
            peers = ([adaptive(method, r, slope) for r in TOLERANCES] for method in methods)
            row[kind] = np.nanmin([loosest_s(settings, pieces, form, truth, 1e-3) for settings in peers]) / warm_s
        for goal in (1e-3, 1e-8):
            row[f"RK4 {goal:g}"] = loosest_s(steppers, pieces, form, truth, goal) / warm_s
        error = np.abs(exact(pieces, form) - truth).max() / np.abs(truth).max()
        peers_text = ", ".join(f"{kind} x {ratio:.3g}" for kind, ratio in row.items())
        print(
            f"tau {tau_s:g} s, {name}: {1e3 * warm_s:.3f} ms ({1e3 * cold_s:.2f} cold), error {error:.0e}; {peers_text}"
        )
        for kind, ratio in row.items():
            ratios.setdefault(kind, []).append(ratio)
    tell("skin and finger, least of all rows: best solve_ivp over ours at 1e-3", min(ratios["plain"]), at_least=100)
    tell("the same with a compiled right-hand side", min(ratios["compiled"]))
    tell("least of all rows: compiled RK4 at 1e-3 over ours", np.nanmin(ratios["RK4 0.001"]), at_least=1 / 3)
    least = np.nanmin(ratios["RK4 1e-08"])
    tell("least of all rows that reach it: compiled RK4 at 1e-8 over ours", least, at_least=1)


if __name__ == "__main__":
    motion()
