"""Settings of accuracy problems of motion with Newmark's and Verlet's methods and `solve_ivp`."""

from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tactometry.experiments.accuracy.measure import Setting
from tactometry.experiments.accuracy.problems import electrovibration, plate_motion
from tactometry.stimuli.electrovibration import Skin
from tactometry.stimuli.electrovibration.attraction.force import force_per_square_volt_n
from tactometry.stimuli.electrovibration.motion.dry_friction import DryFriction
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE

Real = NDArray[np.float64]
FACTORS = (4, 16, 64, 256)
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8)


def modes() -> list[Setting]:
    oscillators = A4_PROTOTYPE.oscillators(plate_motion.TONE_TO_HZ)
    stepped = [
        Setting(f"{plate_motion.TONE_RATE_HZ * k / 1e3:g} kHz", partial(_stepped, step, oscillators, k), contender=name)
        for name, step in {"Newmark": newmark, "Verlet": verlet}.items()
        for k in FACTORS
    ]
    adaptive = [
        Setting(f"rtol {tolerance:g}", partial(_adaptive, oscillators, tolerance), contender="solve_ivp DOP853")
        for tolerance in TOLERANCES[:3]
    ]
    return [*stepped, *adaptive]


def _stepped(step: Any, modes: Oscillators, factor: int) -> Real:
    n, step_s = len(plate_motion.times_s(1)), 1 / (plate_motion.TONE_RATE_HZ * factor)
    with np.errstate(all="ignore"):
        result = step(modes.omega_rad_per_s, modes.decay_per_s, plate_motion.OMEGA_RAD_PER_S, step_s, factor, n)
    return np.asarray(result)


@njit(cache=True)
def newmark(omega, a, tone, h, factor, n):  # type: ignore[no-untyped-def]
    """Solve q'' + 2 a q' + w^2 q = sin(tone t) by average acceleration."""
    out = np.zeros((len(omega), n))
    for i in range(len(omega)):
        q, v, acc, w2 = 0.0, 0.0, 0.0, omega[i] ** 2
        for k in range(1, (n - 1) * factor + 1):
            q_guess, v_guess = q + h * v + h * h / 4 * acc, v + h / 2 * acc
            acc = (np.sin(tone * k * h) - 2 * a[i] * v_guess - w2 * q_guess) / (1 + a[i] * h + w2 * h * h / 4)
            q, v = q_guess + h * h / 4 * acc, v_guess + h / 2 * acc
            if k % factor == 0:
                out[i, k // factor] = q
    return out


@njit(cache=True)
def verlet(omega, a, tone, h, factor, n):  # type: ignore[no-untyped-def]
    """Solve the same equation by central differences."""
    out = np.zeros((len(omega), n))
    for i in range(len(omega)):
        before, now, w2 = 0.0, 0.0, omega[i] ** 2
        for k in range((n - 1) * factor):
            push = np.sin(tone * k * h) - w2 * now
            before, now = now, (2 * now - (1 - a[i] * h) * before + h * h * push) / (1 + a[i] * h)
            if (k + 1) % factor == 0:
                out[i, (k + 1) // factor] = now
    return out


def _adaptive(modes: Oscillators, tolerance: float) -> Real:
    n, tone, at_s = modes.n, plate_motion.OMEGA_RAD_PER_S, plate_motion.times_s(1)
    w2, loss = modes.omega_rad_per_s**2, 2 * modes.decay_per_s

    def slope(t: float, y: Real) -> Real:
        return np.concatenate([y[n:], np.sin(tone * t) - loss * y[n:] - w2 * y[:n]])

    scale = tolerance / np.concatenate([w2, np.sqrt(w2)])
    result = solve_ivp(slope, (0, at_s[-1]), np.zeros(2 * n), "DOP853", at_s, rtol=tolerance, atol=scale)
    return np.asarray(result.y[:n])


def skin() -> list[Setting]:
    return [
        Setting(f"rtol {tolerance:g}", partial(_skin, method, tolerance), contender=f"solve_ivp {method}")
        for method in ("RK45", "LSODA")
        for tolerance in TOLERANCES
    ]


def _skin(method: str, tolerance: float) -> Real:
    """Return the force while the voltage across the stratum corneum relaxes."""
    p, omega, at_s = Skin(), 2 * np.pi * electrovibration.FREQUENCY_HZ, electrovibration.sample_times_s(1)

    def slope(t: float, y: Real) -> Real:
        return np.asarray(p.k * 100 * omega * np.cos(omega * t) - y / p.tau_s)

    result = solve_ivp(slope, (0, at_s[-1]), [0.0], method, at_s, rtol=tolerance, atol=100 * tolerance)
    return np.asarray(force_per_square_volt_n(p, electrovibration.AREA_M2) * result.y[0] ** 2)


def break_away() -> list[Setting]:
    return [
        Setting(f"width {1e2 * tolerance:g} m/s", partial(_smooth, tolerance), contender="solve_ivp, tanh friction")
        for tolerance in (1e-4, 1e-5, 1e-6)
    ]


def _smooth(tolerance: float) -> tuple[float, float]:
    """Return the time at which friction reaches 99 %. Friction is a steep, smooth function of the speed."""
    finger, speed, width = electrovibration.pad(), electrovibration.SPEED_M_PER_S, 1e2 * tolerance
    limit_n = DryFriction().static * electrovibration.FORCE_N

    def slope(_: float, y: Real) -> list[float]:
        pull = limit_n * np.tanh((speed - y[1]) / width)
        spring = finger.stiffness_n_per_m * y[0] + finger.damping_n_s_per_m * y[1]
        return [y[1], (pull - spring) / finger.mass_kg]

    def away(_: float, y: Real) -> float:
        return float(np.tanh((speed - y[1]) / width) - 0.99)

    away.terminal = True  # type: ignore[attr-defined]
    result = solve_ivp(slope, (0, 0.2), [0.0, speed], "LSODA", events=away, rtol=tolerance, atol=1e-9)
    time_s = float(result.t_events[0][0]) if result.t_events[0].size else np.nan
    return time_s, time_s
