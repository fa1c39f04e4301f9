"""Time-reversal scenes: physics, lift-off, stage order and accuracy."""

import itertools
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from scene_cases import RESTING, TIME_REVERSAL, VOLT, effect, finest_of, refusal, screen, screens, small_screen, tuned
from scene_errors import LOSSY, accepted, error_of, finer, run
from soak import SOAK

from tactometry.experiments.scenes import path_of
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.stages.truncation import cut, n_frequencies, n_modes
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import drive, emitted, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import field, modal_amplitudes
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact, one_sided_contacts
from tactometry.stimuli.time_reversal.plate.glass import BOROFLOAT_33
from tactometry.stimuli.time_reversal.responses.load import loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce, border

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4)
PATCHES, ONE_BIT = effect("patches", side_m=8e-3), effect("one_bit")


# --- what it computes is what the plate does


FOCUS, RATE_HZ, BAND = (0.05, 0.04), 960e3, Band(0.0, 15e3, 3e3)
SMALL = BOROFLOAT_33.plate(0.12, 0.09, 1.1e-3, "SSSS")
WHOLE = Screen(SMALL, tuple(border(SMALL, 8, 8e-3)), Attenuation(2e-3))


def learnt_responses():
    return band_limited(impulse_responses(WHOLE, [FOCUS], rate_hz=60e3, duration_s=3e-3, f_max_hz=15e3), BAND)


def test_one_bit_peak_is_sum_of_learnt_responses():
    learnt = learnt_responses()
    amplitude_m = focus_amplitude(drive(learnt, 30.0, OneBit()), learnt)
    assert abs(run(screen(LOSSY, PATCHES, ONE_BIT, accuracy=1e-4))["peak_m"] / amplitude_m - 1) < 5e-3


@pytest.fixture(scope="module")
def fine():
    """Return the drive of the scene at 16 times its clock, and the sample of its focus."""
    signal = drive(learnt_responses(), 30.0, OneBit())
    n = signal.samples.shape[1]
    spectrum = np.fft.rfft(np.pad(signal.samples, ((0, 0), (n, n)))) * BAND.at(np.fft.rfftfreq(3 * n, 1 / 60e3))
    return Signal(16 * np.fft.irfft(spectrum, 48 * n), RATE_HZ, "V"), 16 * (2 * n - 1)


def around_focus(got, course, focus):
    """Return a course of a scene at the samples around the focus, and these samples."""
    at = np.arange(focus - 3000, focus + 900)
    return np.interp((at - focus) / RATE_HZ, got["t_s"], course), at


def test_focus_signal_matches_time_domain(fine):
    signal, focus = fine
    responses = impulse_responses(WHOLE, [FOCUS], rate_hz=RATE_HZ, duration_s=12e-3, f_max_hz=120e3)
    expected = emitted(signal, responses)[0]
    got = run(screen(LOSSY, PATCHES, ONE_BIT, outputs=("t_s", "focus_displacement_m"), accuracy=1e-3))
    course, at = around_focus(got, got["focus_displacement_m"], focus)
    assert np.abs(course - expected[at]).max() < 1e-3 * np.abs(expected[focus])


def test_field_and_energy_match_time_domain(fine):
    signal, focus = fine
    outputs = ("x_m", "y_m", "field_m", "energy_j")
    got = run(screen(LOSSY, PATCHES, ONE_BIT, effect("drive_energy"), outputs=outputs, accuracy=1e-2))
    expected = field(WHOLE, signal, focus, (got["x_m"], got["y_m"]), 240e3)
    assert np.abs(got["field_m"] - expected).max() < 1e-2 * np.abs(expected).max()
    omega = WHOLE.oscillators(240e3).omega_rad_per_s
    strain_j = 0.5 * SMALL.mass_kg * np.sum((omega * modal_amplitudes(WHOLE, signal, focus, 240e3)) ** 2)
    assert abs(got["energy_j"] / strain_j - 1) < 1e-2


@pytest.mark.parametrize("quantiser", [(), (ONE_BIT,)], ids=["analogue", "one_bit"])
def test_the_power_does_not_change_with_the_clock(quantiser):
    scene = screen(LOSSY, PATCHES, *quantiser, effect("drive_energy"), outputs=("power_w",), accuracy=1e-2)
    rate_hz = scene.surface.rate_hz
    clocks = (replace(scene, surface=replace(scene.surface, rate_hz=times * rate_hz)) for times in (2, 4, 8))
    power_w = [float(run(clock)["power_w"]) for clock in clocks]
    assert power_w == pytest.approx([power_w[-1]] * 3, rel=0.02)


@pytest.mark.parametrize("impedance", ["lumped", "tissue"])
def test_loaded_focus_matches_loaded_responses(fine, impedance):
    signal, focus = fine
    finger = Fingertip(impedance=impedance).contact(FOCUS, 2.0)
    sampling = {"rate_hz": RATE_HZ, "duration_s": 12e-3, "f_max_hz": 400e3}
    expected = emitted(signal, loaded_responses(WHOLE, [FOCUS], [finger], **sampling))[0]
    load = replace(effect("finger_load"), impedance=impedance)
    got = run(screen(LOSSY, PATCHES, ONE_BIT, load, outputs=("t_s", "focus_displacement_m"), accuracy=1e-3))
    course, at = around_focus(got, got["focus_displacement_m"], focus)
    assert np.abs(course - expected[at]).max() < 1e-2 * np.abs(expected[focus])


def test_contact_force_is_resistance_times_speed():
    outputs = ("t_s", "focus_displacement_m", "contact_displacement_m", "contact_force_n")
    got = run(screen(LOSSY, PATCHES, ONE_BIT, effect("finger_load"), outputs=outputs, accuracy=1e-3))
    np.testing.assert_allclose(got["contact_displacement_m"][0], got["focus_displacement_m"], atol=1e-12)
    velocity = np.gradient(got["contact_displacement_m"][0], got["t_s"])
    np.testing.assert_allclose(got["contact_force_n"][0], 10.0 * velocity, atol=1e-2 * 10.0 * np.abs(velocity).max())


def test_lift_off_matches_time_domain_solution(fine):
    signal, focus = fine
    responses = impulse_responses(WHOLE, [FOCUS], rate_hz=RATE_HZ, duration_s=12e-3, f_max_hz=120e3)
    free_m = emitted(signal, responses)[0]
    expected = one_sided_contact(WHOLE, FOCUS, free_m, RATE_HZ, 120e3, 0.05)
    thrown = (LOSSY, PATCHES, ONE_BIT, effect("finger_load"), effect("lift_off"))
    outputs = ("t_s", "contact_displacement_m", "contact_lost_s")
    got = run(replace(screen(*thrown, outputs=outputs, accuracy=1e-3), contacts=(FingerContact(0.05),)))
    course, at = around_focus(got, got["contact_displacement_m"][0], focus)
    assert course == pytest.approx(expected.displacement_m[at], abs=5e-3 * np.abs(free_m).max())
    assert got["contact_lost_s"] == pytest.approx([expected.apart.sum() / RATE_HZ], rel=0.1)


@pytest.mark.parametrize("voltage_v", [0.0, -30.0])
def test_zero_voltage_is_silent_and_sign_is_irrelevant(voltage_v):
    outputs = ("peak_m", "sensation_db", "sound_level_dba")
    plan = screen(LOSSY, effect("airborne_sound"), effect("focus_detection"), outputs=outputs, accuracy=0.1).resolve()
    silence = {"peak_m": 0.0, "sensation_db": -np.inf, "sound_level_dba": -np.inf}
    assert plan.run({"voltage_v": voltage_v}) == (plan.run({"voltage_v": 30.0}) if voltage_v else silence)


def test_course_passes_through_peak_at_focus_instant():
    got = run(screen(LOSSY, ONE_BIT, outputs=("peak_m", "t_s", "focus_displacement_m")))
    assert got["focus_displacement_m"][got["t_s"] == 0] == pytest.approx([got["peak_m"]], rel=1e-9)
    assert np.abs(got["focus_displacement_m"]).max() == pytest.approx(got["peak_m"], rel=1e-9)


def test_a_movie_shows_the_field_at_the_focus_instant():
    outputs = ("field_m", "frames_s", "movie_m")
    got = run(screen(LOSSY, ONE_BIT, effect("movie", n_frames=5, span_s=1e-4), outputs=outputs, accuracy=0.1))
    assert got["movie_m"].shape == (5, *got["field_m"].shape)
    np.testing.assert_allclose(got["movie_m"][2], got["field_m"], atol=1e-9 * np.abs(got["field_m"]).max())
    assert np.abs(got["movie_m"][2]).max() > np.abs(got["movie_m"][0]).max()


@pytest.mark.parametrize("f_max_hz", [15e3, 60e3])
def test_movie_has_eight_frames_per_shortest_period(f_max_hz):
    """At two frames per period of 60 kHz, waves appeared to run back."""
    scene = screen(LOSSY, ONE_BIT, effect("movie"), outputs=("frames_s",), accuracy=0.1)
    surface = replace(scene.surface, f_max_hz=f_max_hz, rate_hz=4 * f_max_hz)
    frames_s = run(replace(scene, surface=surface))["frames_s"]
    assert 0.9 / (8 * f_max_hz) < np.diff(frames_s).max() <= 1.0001 / (8 * f_max_hz)
    assert frames_s[len(frames_s) // 2] == 0


# --- off costs nothing


@pytest.mark.parametrize("kind", sorted(TIME_REVERSAL))
def test_active_effect_changes_or_adds_its_output(kind):
    output = TIME_REVERSAL[kind][2]
    on = run(screen(*tuned(kind), outputs=("t_s", output)))[output]
    assert np.isfinite(on).all()
    assert np.any(on)
    if output == "focus_displacement_m":
        without = run(screen(outputs=("t_s", output)))[output]
        assert on.shape != without.shape or np.abs(on - without).max() > 1e-3 * np.abs(without).max()


def test_peak_output_needs_no_course_map_or_movie():
    plan = screen(LOSSY, PATCHES, ONE_BIT, effect("movie"), outputs=("peak_m",)).resolve()
    given = {stage.gives for stage in plan.stages}
    assert not given & {"per_volt_course", "per_volt_field", "x_m", "per_volt_movie", "t_s"}
    assert [stage.name for stage in plan.stages][-2:] == ["instant", "peak"]


def test_peak_is_the_same_when_map_is_requested():
    assert run(screen(ONE_BIT))["peak_m"] == pytest.approx(
        run(screen(ONE_BIT, outputs=("peak_m", "field_m")))["peak_m"], rel=1e-2
    )


# --- the tolerance is kept


OUTPUTS = {
    "focus_displacement_m": (LOSSY, PATCHES, ONE_BIT),
    "peak_m": (LOSSY, PATCHES),
    "field_m": (LOSSY, PATCHES, ONE_BIT),
    "contact_force_n": (LOSSY, ONE_BIT, effect("finger_load", mass_kg=1e-4)),
    "contact_displacement_m": (LOSSY, PATCHES, effect("finger_load")),
    "sound_level_dba": (LOSSY, ONE_BIT, effect("airborne_sound")),
    "energy_j": (LOSSY, PATCHES, ONE_BIT, effect("drive_energy")),
    "sensation_db": (LOSSY, PATCHES, ONE_BIT, effect("focus_detection")),
}
BESIDE = {"field_m": ("x_m", "y_m"), "peak_m": (), "energy_j": (), "sound_level_dba": (), "sensation_db": ()}


@pytest.mark.parametrize("output", sorted(OUTPUTS))
def test_accuracy_is_met_and_looser_accuracy_costs_less(output):
    scene = Scene(small_screen(), OUTPUTS[output], (*BESIDE.get(output, ("t_s",)), output), 0.01, RESTING)
    reference = run(finer(scene))
    costs = []
    for accuracy in ACCURACIES:
        plan = replace(scene, accuracy=accuracy).resolve()
        true = error_of(run(replace(scene, accuracy=accuracy)), reference, output)
        assert true <= plan.error <= accuracy
        assert plan.error <= 10 * max(true, accuracy / 10)
        costs.append(plan.n_operations)
    assert costs == sorted(costs)
    assert costs[0] < costs[-1]


@given(screens(outputs=("t_s", "focus_displacement_m", "peak_m", "contact_force_n")))
@settings(max_examples=200 if SOAK else 8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_random_scenes_keep_their_accuracy(scene):
    if scene.find("load") is None:
        scene = replace(scene, outputs=scene.outputs[:-1])
    finest = finer(scene) if SOAK else finest_of(scene, 1e-4, 3e-4)
    reference = run(finest)
    for requested in accepted(scene, ACCURACIES if SOAK else ACCURACIES[:3]):
        got, predicted = run(requested), requested.resolve().error
        for output in scene.outputs[1:]:
            true = error_of(got, reference, output)
            assert true <= requested.accuracy
            assert true <= predicted + finest.accuracy


@pytest.mark.parametrize("aside_m", [0.0, 2e-3, 8e-3, 25e-3])
@pytest.mark.parametrize("n", [2, 7])
def test_focus_near_patch_meets_accuracy(n, aside_m):
    near = border(small_screen().plate, n, 8e-3, 12e-3)[0]
    surface = small_screen(n_transducers=n, focus_x_m=near.x_m, focus_y_m=near.y_m + 4e-3 + aside_m)
    scene = Scene(surface, (LOSSY, PATCHES), ("t_s", "focus_displacement_m"), 0.01)
    reference = run(finer(scene))
    for accuracy in ACCURACIES:
        requested = replace(scene, accuracy=accuracy)
        assert error_of(run(requested), reference, "focus_displacement_m") <= requested.resolve().error <= accuracy


# --- order


def test_the_order_of_the_tuple_does_not_matter():
    kinds = ("attenuation", "patches", "one_bit", "audible_filter")
    chosen = [effect(kind, **TIME_REVERSAL[kind][0]) for kind in kinds]
    first, *others = (screen(*order).resolve() for order in itertools.permutations(chosen))
    assert all(plan == first for plan in others)


# --- memory


@pytest.mark.parametrize("duration_s", [50e-3, 0.1])
@pytest.mark.parametrize(("repetition_hz", "envelope"), [(200.0, "rectangular"), (500.0, "exponential")])
def test_trains_under_a_finger_on_the_a4_screen_fit(repetition_hz, envelope, duration_s):
    """P1 of 0.1 s takes 3.7e7 numbers for all outputs of the scene at 1e-2."""
    a4 = load_scene(path_of("a4-screen")).scene
    train = effect("repetition", repetition_hz=repetition_hz, duration_s=duration_s, envelope=envelope)
    assert replace(a4, effects=(*a4.effects, train)).resolve().error <= a4.accuracy


def test_loaded_motion_stays_within_its_memory_limit():
    """Only the free and the loaded motion are in memory at once."""
    scene = screen(effect("repetition", duration_s=0.2), effect("finger_load"), outputs=("contact_force_n",))
    found = cut(scene, scene.accuracy / 2)
    n_numbers = n_modes(scene, found.modes_to_hz) * n_frequencies(scene, found)
    plan = scene.resolve()
    plan.run(VOLT)
    tracemalloc.start()
    try:
        replace(plan).run(VOLT)
        peak_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak_bytes <= 36 * n_numbers


# --- lift-off

DRIVE = (LOSSY, effect("patches", side_m=8e-3), effect("one_bit"))
COURSES = ("t_s", "focus_displacement_m", "contact_displacement_m", "contact_force_n")
LIGHT = (FingerContact(0.05),)
"""Without contact for 1 % of the time."""


def touched(*more, contacts=LIGHT, outputs=(*COURSES, "contact_lost_s"), accuracy=1e-2):
    return replace(screen(*DRIVE, effect("finger_load"), *more, outputs=outputs, accuracy=accuracy), contacts=contacts)


def test_finger_in_contact_matches_linear_contact():
    firm = (FingerContact(2.0),)
    opened, linear = (
        run(replace(touched(*more, contacts=firm, outputs=COURSES), settings={"sampling": {"factor": 8}}))
        for more in ((effect("lift_off"),), ())
    )
    for name in COURSES:
        assert opened[name] == pytest.approx(linear[name], abs=1e-2 * np.abs(linear[name]).max())
    assert run(touched(effect("lift_off"), contacts=firm, outputs=("contact_lost_s",)))["contact_lost_s"] == 0


def test_lift_off_limits_pull_to_static_force():
    opened, linear = run(touched(effect("lift_off"))), run(touched(outputs=COURSES))
    assert linear["contact_force_n"].min() < -0.06
    assert opened["contact_force_n"].min() == pytest.approx(-0.05, rel=1e-12)
    assert opened["contact_lost_s"] > 0


def test_lift_off_error_is_within_predicted_error():
    for force_n in (0.05, 2.0):
        scene = touched(effect("lift_off"), contacts=(FingerContact(force_n),), outputs=COURSES[:3], accuracy=3e-3)
        plan = scene.resolve()
        (stage,) = (stage for stage in plan.stages if stage.name == "lift_off")
        finest = replace(scene, settings={"lift_off": {"finer": 16 * stage.settings["finer"]}})
        got, true = plan.run({"voltage_v": 30.0}), run(finest)
        for name in COURSES[1:3]:
            assert np.abs(got[name] - true[name]).max() <= stage.error * np.abs(true[name]).max()


def test_two_fingers_in_contact_match_linear_loads():
    whole = screen(*DRIVE).surface.plate
    places, rate_hz, band = [(0.05, 0.04), (0.09, 0.06)], 400e3, 8e3
    sampling = {"rate_hz": rate_hz, "duration_s": 3e-3, "f_max_hz": band}
    struck = Screen(whole, (PointForce(0.08, 0.03),), Attenuation(2e-3))
    loads = [Fingertip().load(place, 2.0) for place in places]
    free_m = impulse_responses(struck, places, **sampling).samples[:, 0]
    expected = loaded_responses(struck, places, loads, **sampling).samples[:, 0]
    found = one_sided_contacts(struck, free_m, loads, np.array([2.0, 2.0]), rate_hz, band)
    assert not found.apart.any()
    assert found.displacement_m == pytest.approx(expected, abs=5e-3 * np.abs(expected).max())


def test_light_finger_lifts_off_next_to_firm_finger():
    contacts = (FingerContact(0.05), FingerContact(2.0, x_m=0.09, y_m=0.06))
    got = run(touched(effect("lift_off"), contacts=contacts))
    light_s, firm_s = got["contact_lost_s"]
    assert light_s > 0 == firm_s


def test_finger_stays_in_contact_without_voltage():
    got = touched(effect("lift_off")).resolve().run({"voltage_v": 0.0})
    assert not any(np.any(got[name]) for name in (*COURSES[1:], "contact_lost_s"))


# --- the accuracy of each effect and of quantised spectra

OF_EFFECTS = {
    "foci": ("peaks_m",),
    "repetition": ("t_s", "focus_displacement_m"),
    "temperature_drift": ("t_s", "focus_displacement_m"),
    "amplifier": ("t_s", "focus_displacement_m"),
    "shear": ("t_s", "focus_displacement_m"),
}


def error_of_peaks(got, reference, output):
    return abs(got[output] - reference[output]).max() / abs(reference[output]).max()


@pytest.mark.parametrize("kind", sorted(OF_EFFECTS))
def test_an_effect_keeps_the_accuracy(kind):
    scene = screen(LOSSY, *tuned(kind), outputs=OF_EFFECTS[kind])
    error = error_of_peaks if kind == "foci" else error_of
    reference = run(finer(scene))
    for accuracy in (1e-2, 1e-3, 1e-4):
        requested = replace(scene, accuracy=accuracy)
        assert kind in {stage.effect for stage in requested.resolve().stages}
        assert error(run(requested), reference, OF_EFFECTS[kind][-1]) <= requested.resolve().error <= accuracy


COURSE = ("t_s", "focus_displacement_m")
QUANTISERS = (
    effect("one_bit"), effect("sigma_delta", order=1), effect("sigma_delta", order=2),
    effect("pulse_width", carrier_hz=15e3),
)  # fmt: skip


@st.composite
def quantised(draw):
    scene = draw(screens(COURSE))
    others = tuple(each for each in scene.effects if each.slot != "quantiser")
    return replace(scene, effects=(draw(st.sampled_from(QUANTISERS)), *others))


def spectrum(got, n_lines):
    """Return the first lines of the course at the focus.

    Its duration does not depend on the sampling.
    """
    course = got["focus_displacement_m"][:-1]
    return np.fft.rfft(course)[:n_lines] / course.size


@given(quantised())
@settings(max_examples=100 if SOAK else 5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_quantised_spectrum_meets_accuracy_or_is_refused(scene):
    """Relative to its highest line."""
    finest = finest_of(scene, *((3e-5, 1e-4) if SOAK else ()), 3e-4, 9e-4)
    found = run(finest)
    n_lines = round(scene.surface.f_max_hz * (found["t_s"][-1] - found["t_s"][0]))
    reference = spectrum(found, n_lines)
    for requested in accepted(scene, (1e-1, 1e-2, 1e-3, 1e-4) if SOAK else (1e-1, 1e-2, 1e-3)):
        off = np.abs(spectrum(run(requested), n_lines) - reference).max() / np.abs(reference).max()
        assert off <= requested.accuracy + finest.accuracy


@pytest.mark.parametrize("quantiser", QUANTISERS, ids=lambda each: each.kind)
def test_quantised_drive_is_refused_at_unreachable_accuracy(quantiser):
    scene = screen(LOSSY, quantiser, outputs=COURSE, accuracy=1e-12)
    assert "error budget of" in refusal(scene)
    assert "loosen the accuracy" in refusal(scene)
