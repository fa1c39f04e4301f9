"""Skin and finger: the exact motion against `solve_ivp` and a compiled RK4, error beside time.

    OMP_NUM_THREADS=1 python benchmarks/electrovibration_motion.py

50 ms, 288 outputs, one tau per row. For each peer the loosest setting that reaches an error of 1e-3 (of the largest
deflection) counts; the peers restart at every kink of the voltage; each has a plain and a
compiled right-hand side. The reference
is the mechanical equation under the closed-form force at 1e-12, so an error near 1e-11 is the reference's own.
"""

import statistics
import sys
import time
from collections.abc import Callable
from itertools import pairwise, product
from typing import Any

import numpy as np
from measured import tell
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tactometry.stimuli.electrovibration import CoulombFriction, Finger, Pieces, Sine, Skin, Solution, Step, Trapezoid
from tactometry.stimuli.electrovibration.attraction.force import ForceForm, force_form
from tactometry.stimuli.electrovibration.motion.driven_motion import plan_of
from tactometry.stimuli.electrovibration.motion.finger import sliding

Real = NDArray[np.float64]
FINGER, MU, END_S = Finger(), 0.5, 0.05
FRICTION = CoulombFriction(MU)
T_S = np.linspace(0, END_S, 289)[1:]
INPUTS = {
    "step": Step(duration_s=END_S).pieces(40.0),
    "trapezoid": Trapezoid(rise_s=1e-3, high_s=8e-3, fall_s=1e-3, low_s=8e-3, duration_s=END_S).pieces(40.0),
    "sine": Sine(frequency_hz=240.0, ramp_s=0.0, duration_s=END_S).pieces(40.0),
}
TAUS_S = (1e-6, 1e-4, 5e-3, 1.0)
TOLERANCES = tuple(float(f"{r:.1g}") for r in np.geomspace(1e-2, 1e-8, 13))
METHODS = ("LSODA", "RK45", "RK23", "DOP853", "Radau", "BDF")
EXPLICIT = ("RK45", "RK23", "DOP853")


def form_of(tau_s: float) -> ForceForm:
    return force_form("sc_layer", Skin(corneum_resistivity_ohm_m=2e4 * tau_s / Skin().tau_s), 1e-4)


@njit(cache=True)  # type: ignore[untyped-decorator]
def rhs(t: float, y: Real, p: Real) -> Real:
    """(V_c', x', v') with V_c the capacitor's voltage: V_sc = k (V - V_c); p holds the piece and the parameters."""
    voltage = p[0] + p[1] * (t - p[2]) + p[3] * np.cos(p[4] * t) - p[5] * np.sin(p[4] * t)
    layer = voltage - y[0]
    out = np.empty(3)
    out[0] = p[6] * layer
    out[1] = y[2]
    out[2] = p[7] * layer * layer - p[8] * y[2] - p[9] * y[1]
    return out


@njit(cache=True)  # type: ignore[untyped-decorator]
def rk4(y: Real, start: float, stop: float, n_steps: int, p: Real, at: Real) -> tuple[Real, Real]:
    """Deflections at `at` (cubic between steps) and the last state, in equal steps."""
    h, found, here = (stop - start) / n_steps, np.empty(len(at)), 0
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
            found[here] = y[1] + u * jump + curve
            here += 1
        y = after
    return found, y


def parameters(pieces: Pieces, form: ForceForm, piece: int) -> Real:
    gain, rate = form.relaxations.gains[0], form.relaxations.rates_per_s[0]
    c = pieces.harmonics_v[piece, 0] if pieces.frequencies_hz.size else 0j
    omega = 2 * np.pi * pieces.frequencies_hz[0] if pieces.frequencies_hz.size else 0.0
    m = FINGER.mass_kg
    return np.array([
        pieces.offsets_v[piece], pieces.slopes_v_per_s[piece], pieces.starts_s[piece], c.real, omega, c.imag, rate,
        MU * form.newton_per_v2 * gain**2 / m, FINGER.damping_n_s_per_m / m, FINGER.stiffness_n_per_m / m,
    ])  # fmt: skip


def over_pieces(
    pieces: Pieces, form: ForceForm, leg: Callable[[Real, float, float, Real, Real], tuple[Real, Real]]
) -> Real:
    """Deflections at `T_S` by a solver that restarts at each piece."""
    y, found = np.zeros(3), []
    stops = [*pieces.starts_s[1:], pieces.end_s]
    for i, (start, stop) in enumerate(zip(pieces.starts_s, stops, strict=True)):
        at = T_S[(start < T_S) & (stop >= T_S)]
        part, y = leg(y, start, stop, parameters(pieces, form, i), at)
        found.append(part)
    return np.concatenate(found)


def adaptive(method: str, tolerance: float, slope: Callable[..., Any]) -> Callable[[Pieces, ForceForm], Real]:
    atol = [tolerance * 100, tolerance * 1e-9, tolerance * 1e-7]

    def leg(y: Real, start: float, stop: float, p: Real, at: Real) -> tuple[Real, Real]:
        r = solve_ivp(slope, (start, stop), y, method=method, t_eval=np.r_[at[at < stop], stop], args=(p,),
                      rtol=tolerance, atol=atol)  # fmt: skip
        return (r.y[1, : len(at)], r.y[:, -1]) if r.success else (np.full(len(at), np.nan), np.full(3, np.nan))

    return lambda pieces, form: over_pieces(pieces, form, leg)


def stepped(n_per_second: float) -> Callable[[Pieces, ForceForm], Real]:
    def leg(y: Real, start: float, stop: float, p: Real, at: Real) -> tuple[Real, Real]:
        found, last = rk4(y, start, stop, max(1, round((stop - start) * n_per_second)), p, at)
        return found, last

    return lambda pieces, form: over_pieces(pieces, form, leg)


def exact(pieces: Pieces, form: ForceForm) -> Real:
    motion = sliding(T_S, pieces, form, finger=FINGER, friction=FRICTION, force_n=1e-30)
    return motion.deflection_m


def reference(pieces: Pieces, form: ForceForm) -> Real:
    solved, tau_s = Solution(pieces, form.relaxations), 1 / form.relaxations.rates_per_s[0]
    m, c, k = FINGER.mass_kg, FINGER.damping_n_s_per_m, FINGER.stiffness_n_per_m
    starts = np.array([x for s in pieces.starts_s for x in (s, s + 3 * tau_s, s + 40 * tau_s) if x < pieces.end_s])
    nodes = np.unique(np.r_[starts, pieces.end_s])
    y, found = np.zeros(2), []
    for start, stop in pairwise(nodes):
        inner = np.nextafter(stop, 0)

        def slope(t: float, y: Real, inner: float = inner) -> list[float]:
            push = MU * form.newton_per_v2 * float(solved.at(min(t, inner))) ** 2
            return [y[1], (push - c * y[1] - k * y[0]) / m]

        at = T_S[(start < T_S) & (stop >= T_S)]
        r = solve_ivp(slope, (start, stop), y, method="DOP853", t_eval=np.r_[at[at < stop], stop], rtol=1e-12,
                      atol=1e-22, first_step=(stop - start) / 50)  # fmt: skip
        y = r.y[:, -1]
        found.append(r.y[0, : len(at)])
    return np.concatenate(found)


def milliseconds(run: Callable[[], Any], n: int) -> float:
    """Median of the processor time, which other work on the machine disturbs least."""
    times = []
    for _ in range(n):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return 1e3 * statistics.median(times)


def loosest(
    makers: list[tuple[str, Callable[[Pieces, ForceForm], Real]]],
    pieces: Pieces,
    form: ForceForm,
    truth: Real,
    goal: float,
) -> tuple[str, float, float]:
    """Name, error and time (ms) of the first setting that reaches the goal; a time of NaN if none does."""
    for name, solver in makers:
        with np.errstate(all="ignore"):
            error = np.abs(solver(pieces, form) - truth).max() / np.abs(truth).max()
        if error <= goal:
            return name, error, milliseconds(lambda s=solver: s(pieces, form), 5)
    return "none", np.nan, np.nan


def main() -> None:
    print(
        f"python {sys.version.split()[0]}, numpy {np.__version__}; 50 ms, 288 outputs, error of the largest deflection"
    )
    worst: dict[str, list[float]] = {}
    steppers = [(f"RK4 {n:.0e}/s", stepped(n)) for n in np.geomspace(1e3, 1e8, 21)]
    for tau_s in TAUS_S:
        for name, pieces in INPUTS.items():
            form = form_of(tau_s)
            truth = reference(pieces, form)
            plan_of.cache_clear()
            cold = milliseconds(lambda: exact(pieces, form), 1)  # noqa: B023
            warm = milliseconds(lambda: exact(pieces, form), 51)  # noqa: B023
            error = np.abs(exact(pieces, form) - truth).max() / np.abs(truth).max()
            print(f"\ntau {tau_s:g} s, {name}: exact {warm:.3f} ms warm, {cold:.2f} ms cold, "
                  f"error {error:.0e}")  # fmt: skip
            best = {"compiled": np.inf, "plain": np.inf}
            for method, (kind, slope) in product(METHODS, {"compiled": rhs, "plain": rhs.py_func}.items()):
                makers = [(f"{method} {r:.0e} {kind}", adaptive(method, r, slope)) for r in TOLERANCES]
                if method in EXPLICIT and tau_s < 1e-5:
                    print(f"  {method:24s} left out: stability needs some 1e5 steps")
                    continue
                label, peer_error, peer = loosest(makers, pieces, form, truth, 1e-3)
                best[kind] = min(best[kind], peer) if peer > 0 else best[kind]
                print(f"  {label:24s} {peer:9.2f} ms  error {peer_error:.0e}  x {peer / warm:.0f}")
            ratios = ", ".join(f"x {ms / warm:.0f} ({kind} right-hand side)" for kind, ms in best.items())
            print(f"  best of solve_ivp / exact warm: {ratios}")
            for kind, ms in best.items():
                worst.setdefault(kind, []).append(ms / warm)
            for goal in (1e-3, 1e-8):
                label, peer_error, peer = loosest(steppers, pieces, form, truth, goal)
                print(f"  {label:24s} {peer:9.3f} ms  error {peer_error:.0e}  x {peer / warm:.2f} (goal {goal:g})")
                worst.setdefault(f"{goal:g}", []).append(peer / warm)
    tell("skin and finger, least of all rows: best solve_ivp over ours at 1e-3", min(worst["plain"]), at_least=100)
    tell("the same with a compiled right-hand side", min(worst["compiled"]))
    tell("least of all rows: compiled RK4 at 1e-3 over ours", np.nanmin(worst["0.001"]), at_least=1 / 3)
    tell("least of all rows that reach it: compiled RK4 at 1e-8 over ours", np.nanmin(worst["1e-08"]), at_least=1)


if __name__ == "__main__":
    main()
