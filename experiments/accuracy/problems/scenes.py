"""Accuracy problems of the built-in scenes, by their accuracy setting."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tactometry.signal import Signal
from tactometry.stimuli.electrovibration import AmplitudeModulated, Skin
from tactometry.stimuli.electrovibration.attraction.contact_area import PowerLawArea
from tactometry.stimuli.electrovibration.attraction.force import electrostatic_force_n_at
from tactometry.stimuli.scenes.file import SceneFile, load_scene
from tactometry.stimuli.time_reversal import Band, Fingertip, Screen, drive, impulse_responses
from tactometry.stimuli.time_reversal.focusing.focusing import emitted
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import band_limited, inaudible
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.transducer import border

from ...scenes import path_of
from ..measure import Problem, Real, Reference, Setting, over_largest

ACCURACIES, FINEST = (1e-1, 1e-2, 1e-3, 1e-4), 3e-4
N_PANEL, PANEL_S = 8001, 0.2
FINER, AROUND_S, HEARD_S = 4, 100e-6, 8e-3
HIGHER = (1.5, 2.5, 3.0)
"""Frequencies of the highest modes over the upper limit of the band. Modes above f contribute in proportion to 1/f
and (inertia) 1/f^3. Three values therefore suffice to extrapolate to all modes."""

Samples = tuple[Real, Real]
"""Times (s) and values of a signal."""


def panel() -> Problem:
    """Measure the error of the force of `electrovibration-panel`."""
    scene = load_scene(path_of("electrovibration-panel"))
    force = partial(_samples, scene, "electrostatic_force_n")
    return Problem(
        "largest error of the electrostatic force over its peak, by requested accuracy",
        reference=Reference("the piecewise exact solution", lambda: _exact(scene), 1e-12),
        error=lambda answer, reference: over_largest(np.interp(reference[0], *answer), reference[1]),
        settings=tuple(Setting(f"accuracy {accuracy:g}", partial(force, accuracy)) for accuracy in ACCURACIES),
    )


def _exact(scene: SceneFile) -> Samples:
    tone, t_s = _tone(20e3), np.linspace(0, PANEL_S, N_PANEL)
    pieces = tone.pieces(scene.given["level_db_re_1v"])
    return t_s, electrostatic_force_n_at(t_s, pieces, skin=Skin(), area_m2=_area_m2(), law="sc_layer")


def _tone(rate_hz: float) -> AmplitudeModulated:
    return AmplitudeModulated(240.0, 2_000.0, PANEL_S, 0.02, rate_hz)


def _area_m2() -> float:
    return float(PowerLawArea().area_m2(1.5))


def thin_screen() -> Problem:
    """Measure the error of 0.5 mm glass from 20 to 70 kHz without a finger."""
    return _problem("thin-screen", (), 1e-4)


def a4_screen() -> Problem:
    """Measure the error of the A4 prototype under a 2 N finger at the focus."""
    return _problem("a4-screen", (Fingertip().load((0.121, 0.093), 2.0),), 5e-4)


def hybrid_screen() -> Problem:
    """Measure the error with one finger at the focus and another sliding."""
    return _problem("hybrid-screen", (Fingertip().load((0.121, 0.093), 2.0), Fingertip().load((0.22, 0.15), 1.5)), 5e-4)


def _problem(name: str, loads: Sequence[PlateLoad], uncertainty: float) -> Problem:
    scene = load_scene(path_of(name))
    rate_hz = FINER * _surface(scene).rate_hz
    at_s = np.arange(-round(AROUND_S * rate_hz), 1) / rate_hz
    displacement = partial(_samples, scene, "focus_displacement_m")
    in_time = "impulse responses and drive in the time domain, extrapolated to all modes"

    def before_the_focus(accuracy: float) -> Real:
        return np.asarray(np.interp(at_s, *displacement(accuracy)))

    return Problem(
        "largest error of the displacement in the 0.1 ms before the focus over its peak, by requested accuracy",
        reference=Reference(f"the scene at an accuracy of {FINEST:g}", lambda: before_the_focus(FINEST), FINEST),
        independent=Reference(in_time, lambda: _in_time(scene, loads, len(at_s)), uncertainty),
        error=over_largest,
        settings=tuple(
            Setting(f"accuracy {accuracy:g}", partial(before_the_focus, accuracy)) for accuracy in ACCURACIES[:3]
        ),
    )


def _surface(scene: SceneFile) -> Any:
    return getattr(scene.scene.surface, "time_reversal", scene.scene.surface)


def _samples(scene: SceneFile, output: str, accuracy: float) -> Samples:
    plan = replace(scene.scene, outputs=("t_s", output), accuracy=accuracy).resolve()
    values = plan.run({name: scene.given[name] for name in plan.given})
    return values["t_s"], values[output]


def _in_time(scene: SceneFile, loads: Sequence[PlateLoad], n: int) -> Real:
    """Return the displacement due to a drive computed sample by sample."""
    surface, (screen, cutoff_hz) = _surface(scene), _screen(scene)
    focus, band = [(surface.focus_x_m, surface.focus_y_m)], Band(0.0, surface.f_max_hz, surface.flank_hz)
    timing = {"rate_hz": surface.rate_hz, "duration_s": surface.reversal_s, "f_max_hz": surface.f_max_hz}
    responses = impulse_responses(screen, focus, **timing)
    learnt = inaudible(band_limited(responses, band), cutoff_hz, 2e3)
    signal = _band_limited(drive(learnt, scene.given["voltage_v"], OneBit()), band)
    courses = []
    for factor in HIGHER:
        timing = {"rate_hz": signal.rate_hz, "duration_s": HEARD_S, "f_max_hz": factor * surface.f_max_hz}
        responses = loaded_responses(screen, focus, loads, **timing)
        last = FINER * (2 * learnt.n_samples - 1)
        courses.append(emitted(signal, responses)[0, last - n + 1 : last + 1])
    return np.asarray(np.linalg.solve([[1.0, 1 / f, 1 / f**3] for f in HIGHER], courses)[0])


def _screen(scene: SceneFile) -> tuple[Screen, float]:
    effects, surface = {effect.kind: vars(effect) for effect in scene.scene.effects}, _surface(scene)
    patches = border(surface.plate, surface.n_transducers, effects["patches"]["side_m"], surface.inset_m)
    shear_factor = 5 / 6 if "shear" in effects else None
    screen = Screen(surface.plate, patches, Attenuation(effects["attenuation"]["tau_s"]), shear_factor)
    return screen, effects["audible_filter"]["cutoff_hz"]


def _band_limited(signal: Signal, band: Band) -> Signal:
    """Return the band-limited signal at a higher sampling rate."""
    n = signal.samples.shape[1]
    gain = band.at(np.asarray(np.fft.rfftfreq(3 * n, 1 / signal.rate_hz), dtype=np.float64))
    lines = np.fft.rfft(np.pad(signal.samples, ((0, 0), (n, n)))) * gain
    return Signal(FINER * np.fft.irfft(lines, 3 * FINER * n), FINER * signal.rate_hz, "V")
