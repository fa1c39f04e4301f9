"""Contacts as a low-rank update: equal to a dense solve, right at both extremes, passive; the finger's
published losses.
"""

import math
import tracemalloc

import numpy as np
import pytest
from hard_cases import exact_case, hard_case
from hypothesis import given, settings, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import Contactor, amplitude_loss, ejection_force_n, force_loss
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, focus_amplitude
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.modes import modes_of
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, Receptances, contour, loaded_responses
from tactometry.stimuli.time_reversal.responses.responses import band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen, warmed
from tactometry.stimuli.time_reversal.screen.transducer import PointForce, border

MASS_KG, N_MODES = 0.15, 80
FOCUS = (0.121, 0.093)


def system(
    k: int, seed: int, tau_s: float = 3e-3
) -> tuple[Oscillators, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    omega = np.sort(rng.uniform(1e3, 1e5, N_MODES))
    to, of, at = (rng.normal(size=(N_MODES, n)) for n in (2, 3, k))
    return Oscillators(omega, np.full(N_MODES, 1 / tau_s)), to, of, at, 1j * np.linspace(1e3, 1e5, 7)


def dense(oscillators: Oscillators, to, of, at, stiffness, s) -> np.ndarray:
    """The loaded dynamic stiffness of all modes, solved whole."""
    out = []
    for i, value in enumerate(s):
        diagonal = MASS_KG * (value * (value + 2 * oscillators.decay_per_s) + oscillators.omega_rad_per_s**2)
        whole = np.diag(diagonal) + (at * stiffness[i]) @ at.T
        out.append(to.T @ np.linalg.solve(whole, of))
    return np.moveaxis(np.array(out), 0, 2)


def loaded_receptance(receptances, to, of, at, stiffness):
    return receptances.between(to, of) - receptances.correction(to, of, at, stiffness)


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 20), st.integers(0, 2**32 - 1), st.floats(0.0, 100.0), st.floats(0.0, 1e5))
def test_low_rank_update_is_the_dense_solve(k, seed, resistance, spring):
    oscillators, to, of, at, s = system(k, seed)
    stiffness = (1e-4 * s**2 + resistance * s + spring)[:, None] * np.ones(k)
    found = loaded_receptance(Receptances.of(oscillators, MASS_KG, s), to, of, at, stiffness)
    expected = dense(oscillators, to, of, at, stiffness, s)
    size = np.abs(expected).max()
    hard_case("1 to 20 loads on the plate", (found - expected) / size, 0, 1e-12, against="dense solve", floor=1)


@pytest.mark.parametrize(("n_to", "n_of"), [(1, 3), (3, 1), (2, 2)])
def test_low_rank_update_of_unlike_contacts_between_few_and_many_places(n_to, n_of):
    oscillators, to, of, at, s = system(3, 4)
    to, of = (np.concatenate([to, of], axis=1)[:, part] for part in (slice(0, n_to), slice(2, 2 + n_of)))
    stiffness = s[:, None] * np.array([1.0, 30.0, 500.0]) + np.array([0.0, 1e5, 1e7])
    found = loaded_receptance(Receptances.of(oscillators, MASS_KG, s), to, of, at, stiffness)
    expected = dense(oscillators, to, of, at, stiffness, s)
    assert found.shape == (n_to, n_of, 7)
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.slow
def test_1000_contacts_on_80_modes_take_less_than_150_mb():
    oscillators, to, of, at, s = system(1000, 3)
    receptances, stiffness = Receptances.of(oscillators, MASS_KG, s), np.repeat((0.01 * s)[:, None], 1000, axis=1)
    tracemalloc.start()
    loaded_receptance(receptances, to, of, at, stiffness)
    peak_bytes = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak_bytes < 150e6


def test_1000_contacts_are_the_dense_solve():
    few = slice(0, 30)
    oscillators, *weights, s = system(1000, 3)
    to, of, at = (weight[few] for weight in weights)
    oscillators, s = Oscillators(oscillators.omega_rad_per_s[few], oscillators.decay_per_s[few]), s[:2]
    stiffness = np.repeat((10.0 * s)[:, None], 1000, axis=1) / 1000
    found = loaded_receptance(Receptances.of(oscillators, MASS_KG, s), to, of, at, stiffness)
    expected = dense(oscillators, to, of, at, stiffness, s)
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


def test_finger_of_zero_impedance_changes_nothing_at_all():
    oscillators, to, of, at, s = system(3, 5)
    receptances = Receptances.of(oscillators, MASS_KG, s)
    found = loaded_receptance(receptances, to, of, at, np.zeros((7, 3), complex))
    assert np.array_equal(found, receptances.between(to, of))
    exact_case("finger of no impedance", against="the free plate")


@pytest.mark.parametrize("stiffness", [1e20, math.inf])
def test_finger_of_infinite_impedance_is_the_pinned_closed_form(stiffness):
    """H_rs - H_rc H_cc^-1 H_cs; where a dense solve of the stiff plate is 10 % off."""
    oscillators, to, of, at, s = system(2, 6)
    receptances = Receptances.of(oscillators, MASS_KG, s)
    found = loaded_receptance(receptances, to, of, at, np.full((7, 2), stiffness, complex))
    among, into, out = receptances.between(at, at), receptances.between(at, of), receptances.between(to, at)
    first = [np.moveaxis(part, 2, 0) for part in (out, among, into)]
    expected = receptances.between(to, of) - np.moveaxis(first[0] @ np.linalg.solve(*first[1:]), 0, 2)
    size = np.abs(expected).max()
    hard_case(
        "finger of 1e20 N/m and rigid", (found - expected) / size, 0, 1e-11, against="pinned closed form", floor=1
    )
    at_the_pin = loaded_receptance(receptances, at, of, at, np.full((7, 2), stiffness, complex))
    moved = np.abs(at_the_pin).max() / np.abs(into).max()
    hard_case("motion at a rigid finger", moved, 0, 1e-13, against="none", floor=1)


def test_pinned_contacts_that_coincide_are_refused():
    oscillators, to, of, at, s = system(1, 7)
    twice = np.concatenate([at, at], axis=1)
    with pytest.raises(InvalidParameter, match="pinned contacts that coincide"):
        loaded_receptance(Receptances.of(oscillators, MASS_KG, s), to, of, twice, np.full((7, 2), math.inf, complex))
    exact_case("two rigid contacts at one place", against="refusal")


def test_pin_holds_its_point_and_duplicates_are_refused():
    pin = PlateLoad(0.2, 0.13, stiffness_n_per_m=math.inf)
    both = loaded_responses(screen(), [(0.2, 0.13), FOCUS], [pin], **SAMPLING)
    held, free = band_limited(both, Band(0.0, 10e3, 500.0)).samples[:, :, 20:-20]
    assert np.abs(held).max() < 2e-3 * np.abs(free).max()
    with pytest.raises(InvalidParameter, match="pinned contacts that coincide"):
        loaded_responses(screen(), [FOCUS], [pin, pin], **SAMPLING)


def test_one_load_is_the_textbook_formula():
    """At the contact v' = v / (1 + Y Z)."""
    oscillators, _, of, at, s = system(1, 8)
    receptances = Receptances.of(oscillators, MASS_KG, s)
    mobility = s * receptances.between(at, at)[0, 0]
    found = loaded_receptance(receptances, at, of, at, (10.0 * s)[:, None])
    expected = receptances.between(at, of) / (1 + mobility * 10.0)
    size = np.abs(expected).max()
    hard_case("one load", (found - expected) / size, 0, 1e-13, against="v / (1 + Y Z)", floor=1)


def test_mean_driving_point_mobility_is_that_of_the_infinite_plate():
    """Mean of Re Y over 1-25 kHz and points is 1 / Z_p within 10 %."""
    modes = modes_of(A4_SCREEN, 40e3)
    oscillators = Oscillators(modes.angular_frequency_rad_per_s, np.full(len(modes.m), 1 / 3e-3))
    s = 2j * np.pi * np.linspace(2e3, 25e3, 600)
    from tactometry.stimuli.time_reversal.plate.modes import values

    receptances = Receptances.of(oscillators, A4_SCREEN.mass_kg, s)
    points = values(modes, [0.12, 0.187, 0.081], [0.093, 0.067, 0.141])
    mobility = s * np.einsum("kkf->kf", receptances.between(points, points))
    assert np.mean(mobility.real) * A4_SCREEN.point_impedance_n_s_per_m == pytest.approx(1.0, abs=0.1)


def screen(tau_s: float = 3e-3) -> Screen:
    return Screen(A4_SCREEN, tuple(border(A4_SCREEN, 32)), Attenuation(tau_s))


SAMPLING = {"rate_hz": 60e3, "duration_s": 4e-3, "f_max_hz": 10e3}


def test_loaded_responses_are_causal_and_regular_without_attenuation():
    free = Screen(A4_SCREEN, tuple(border(A4_SCREEN, 4)), Attenuation(math.inf))
    h = loaded_responses(free, [FOCUS], [PlateLoad(0.2, 0.13, 30.0)], **SAMPLING).samples
    assert np.isfinite(h).all()
    assert np.abs(h[:, :, 0]).max() < 1e-4 * np.abs(h).max()


def test_reciprocity_with_a_finger_on_the_plate():
    p, q, load = (0.05, 0.06), (0.22, 0.15), [PlateLoad(0.14, 0.1, 10.0, 1e-4, 500.0)]
    there, back = (
        loaded_responses(Screen(A4_SCREEN, (PointForce(*a),), Attenuation(3e-3)), [b], load, **SAMPLING).samples
        for a, b in ((p, q), (q, p))
    )
    assert there == pytest.approx(back, abs=1e-11 * np.abs(there).max())


def test_a_damper_only_takes_energy():
    free = impulse_responses(screen(), [FOCUS], **SAMPLING).samples
    loaded = loaded_responses(screen(), [FOCUS], [PlateLoad(0.2, 0.13, 20.0)], **SAMPLING).samples
    assert np.sum(loaded[:, :, 120:] ** 2) < np.sum(free[:, :, 120:] ** 2)


EMISSION = Emission(Band(1e3, 25e3), 7e-3, 100e3)
PAIRS = [((0.121, 0.093), (0.2, 0.15)), ((0.187, 0.067), (0.07, 0.12)), ((0.081, 0.141), (0.21, 0.06))]


def test_published_loss_of_30_percent_at_the_focus_at_2_n():
    losses = [amplitude_loss(screen(3.5e-3), focus, [Fingertip().load(focus, 2.0)], EMISSION) for focus, _ in PAIRS]
    assert 0.25 < np.mean(losses) < 0.33


def test_published_loss_of_6_percent_elsewhere_at_2_n():
    losses = [amplitude_loss(screen(3.5e-3), focus, [Fingertip().load(at, 2.0)], EMISSION) for focus, at in PAIRS]
    assert 0.04 < np.mean(losses) < 0.08


def test_relearning_gives_back_the_scattered_part_only():
    focus, at = PAIRS[0]
    learnt, relearnt = (
        amplitude_loss(screen(), focus, [Fingertip().load(at)], EMISSION, relearn=again) for again in (False, True)
    )
    assert 0 < relearnt < learnt
    assert relearnt < 1.3 * 0.04  # absorption alone: tau is 51 ms with nothing but the finger


def test_loss_grows_with_force_from_nothing():
    focus, at = PAIRS[0]
    for place in (focus, at):
        losses = [amplitude_loss(screen(), focus, [Fingertip().load(place, f)], EMISSION) for f in (0.0, 0.3, 1.0, 3.0)]
        assert losses[0] == 0.0
        assert np.all(np.diff(losses) > 0)


def test_a_focus_of_10_um_at_12_5_khz_lifts_6_n():
    assert ejection_force_n(10e-6, 12.5e3) == pytest.approx(6.2, abs=0.05)


def test_force_loss_study_covers_every_condition():
    rows = force_loss(
        screen(),
        PAIRS[0][0],
        {"F": PAIRS[0][0], "P1": PAIRS[0][1]},
        [Contactor("finger"), Contactor("soft", 5e-3), Contactor("rigid", 5e-3)],
        [0.0, 2.0],
        EMISSION,
    )
    assert len(rows) == 12
    assert all(row.loss == 0.0 for row in rows if row.force_n == 0.0)
    loss = {(row.contactor, row.place): row.loss for row in rows if row.force_n == 2.0}
    assert loss["finger", "F"] > loss["finger", "P1"]
    assert loss["rigid", "F"] > loss["soft", "F"]


def test_bigger_soft_contactors_take_more():
    losses = [
        amplitude_loss(screen(), PAIRS[0][0], Contactor("soft", d).loads(A4_SCREEN, PAIRS[0][1], 2.0), EMISSION)
        for d in (2e-3, 5e-3, 10e-3)
    ]
    assert np.all(np.diff(losses) > 0)


def test_contactor_has_seven_dampers_and_a_rigid_tip():
    """Resistance by area, six of the points on 2/3 of the radius; a mass and a Hertz stiffness, both whole."""
    soft, rigid = (Contactor(kind, 5e-3).loads(A4_SCREEN, FOCUS, 0.5) for kind in ("soft", "rigid"))
    assert rigid[:-1] == soft
    assert len(soft) == 7
    assert sum(load.resistance_n_s_per_m for load in soft) == pytest.approx(10.0 * 0.25 * 0.5)
    away = sorted(math.dist((load.x_m, load.y_m), FOCUS) for load in soft)
    assert away == pytest.approx([0.0, *[2.5e-3 * 2 / 3] * 6], abs=1e-15)
    tip = rigid[-1]
    assert (tip.x_m, tip.y_m, tip.mass_kg) == (*FOCUS, 2e-3)
    assert tip.stiffness_n_per_m == pytest.approx((6 * 3e9**2 * 2.5e-3 * 0.5) ** (1 / 3))


def test_all_of_a_finger_grows_with_the_root_of_its_force():
    load = Fingertip(10.0, 4e-4, 300.0).load((0.1, 0.1), 0.5)
    assert (load.resistance_n_s_per_m, load.mass_kg, load.stiffness_n_per_m) == (5.0, 2e-4, 150.0)


def test_loss_after_relearning_is_ratio_of_response_sums():
    """1 bit: each drive makes V times the sum of |h| of the plate that it was learnt on."""
    focus, at = PAIRS[1]
    loads = [Fingertip().load(at)]
    free, loaded = (np.abs(EMISSION.responses(screen(), [focus], some).samples).sum() for some in ((), loads))
    found = amplitude_loss(screen(), focus, loads, EMISSION, relearn=True)
    assert found == pytest.approx(1 - loaded / free, rel=1e-9)


def test_modes_extend_a_tenth_above_the_band():
    assert Emission(Band(0.0, 10e3), 1e-3, 100e3).f_max_hz == pytest.approx(11e3)
    assert Emission(Band(0.0, 24e3), 1e-3, 50e3).f_max_hz == 25e3


def test_focus_survives_small_temperature_drift_only():
    sampling = {"rate_hz": 100e3, "duration_s": 7e-3, "f_max_hz": 25e3}
    cold = impulse_responses(screen(), [FOCUS], **sampling)
    signal = drive(cold, 30.0)
    ratio = []
    for kelvin in (0.0, 3.0, 100.0):
        warm = impulse_responses(warmed(screen(), kelvin), [FOCUS], **sampling)
        ratio.append(focus_amplitude(signal, warm) / focus_amplitude(signal, cold))
    assert ratio[0] == 1.0
    assert ratio[1] > 0.99
    assert ratio[2] < 0.9


def test_contour_leaves_no_wrap_around():
    s, growth, n_fft = contour(1000, 1e5)
    shift = s.real[0]
    assert np.exp(-shift * n_fft / 1e5) == pytest.approx(1e-8)
    assert growth[-1] < 1e4 * (1 + 1e-9)


def test_finger_without_force_causes_no_loss():
    assert amplitude_loss(screen(), FOCUS, [Fingertip().load(FOCUS, 0.0)], EMISSION) == 0.0


def test_plate_is_still_below_its_first_mode():
    sampling = {"rate_hz": 2e3, "duration_s": 5e-3, "f_max_hz": 1.0}
    found = loaded_responses(screen(), [FOCUS], [PlateLoad(*FOCUS, 10.0)], **sampling)
    assert not found.samples.any()
