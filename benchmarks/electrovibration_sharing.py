"""One exponential shared by 10 000 stimuli of one skin, and the error of the propagator over all time constants.

OMP_NUM_THREADS=1 python benchmarks/electrovibration_sharing.py
"""

import time

import mpmath as mp
import numpy as np
from measured import tell

from tactometry.contact import Contact
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    CoulombFriction,
    ElectrovibrationSensation,
    Finger,
    Sine,
    Skin,
    Solution,
    sliding,
    sliding_many,
)
from tactometry.stimuli.electrovibration.attraction.force import force_form
from tactometry.stimuli.electrovibration.motion.driven_motion import plan_of
from tactometry.stimuli.electrovibration.waveforms.pieces import straight
from tactometry.stimuli.scenes.default_scenes import default_scene

T_S = np.linspace(0, 0.05, 289)[1:]


def many_stimuli() -> None:
    form = force_form("sc_layer", Skin(), 1e-4)
    tone = Sine(frequency_hz=240.0, ramp_s=0.0, duration_s=0.05).pieces(0.0)
    heights_v = np.geomspace(1.0, 200.0, 10_000)
    sliding(T_S, tone, form, finger=Finger(), friction=CoulombFriction(), force_n=1.0)
    before = plan_of.cache_info().misses
    start = time.process_time()
    for height_v in heights_v:
        sliding(T_S, tone.scaled(height_v), form, finger=Finger(), friction=CoulombFriction(), force_n=1.0)
    seconds = time.process_time() - start
    tell("10 000 stimuli one by one, 288 outputs each", seconds, "s", at_most=1)
    stimuli = [tone.scaled(height_v) for height_v in heights_v]
    start = time.process_time()
    for part in range(0, 10_000, 500):
        sliding_many(T_S, stimuli[part : part + 500], form, finger=Finger(), friction=CoulombFriction(), force_n=1.0)
    seconds = time.process_time() - start
    made = plan_of.cache_info().misses - before
    print(f"{made} new plans")
    tell("the same, 500 at a time", seconds, "s", at_most=1)


def many_sensations() -> None:
    scene, touch = default_scene(ElectrovibrationSensation()), Contact(1.5, 0.05)
    waveform = AmplitudeModulated(frequency_hz=240.0)
    signals = [waveform.at(level) for level in np.linspace(0, 40, 150)]
    start = time.process_time()
    for trial in range(10_000):
        scene.sensation(signals[trial % 150], touch)
    seconds = time.process_time() - start
    tell("10 000 sensations of 150 signals of 1 s at 20 kHz", seconds, "s")


def propagator_error() -> None:
    times_s, values_v = [0.0, 1e-3, 5e-3, 5.5e-3, 0.02], [0.0, 100.0, 100.0, -50.0, -50.0]
    at_s = np.array([5e-4, 1e-3, 3e-3, 5.2e-3, 0.02])
    worst = 0.0
    for tau_s in np.geomspace(1e-9, 1e3, 25):
        for area_m2 in (0.0, 1e-300, 1e-12, 1e-4, 1.0):
            skin = Skin(corneum_resistivity_ohm_m=2e4 * tau_s / Skin().tau_s)
            found_v = Solution(straight(times_s, values_v), skin.relaxations(area_m2)).at(at_s)
            expected_v = [_reference_v(skin, times_s, values_v, t) for t in at_s]
            worst = max(worst, float(np.abs(found_v - expected_v).max() / np.abs(expected_v).max()))
    tell("exact propagator, tau 1 ns to 1000 s, area 0 to 1 m2: largest error against 50 digits", worst, "of the peak",
         at_most=1e-10)  # fmt: skip


def _reference_v(skin: Skin, times_s: list[float], values_v: list[float], t_s: float) -> float:
    with mp.workdps(50):
        tau, k = mp.mpf(skin.tau_s), mp.mpf(skin.k)
        slopes = np.diff(values_v) / np.diff(times_s)
        kinks = zip(times_s, np.diff(slopes, prepend=0.0), strict=False)
        terms = [
            mp.mpf(kink) * k * tau * (1 - mp.exp((mp.mpf(start) - mp.mpf(t_s)) / tau))
            for start, kink in kinks
            if t_s > start
        ]
        return float(sum(terms))


if __name__ == "__main__":
    propagator_error()
    many_stimuli()
    many_sensations()
