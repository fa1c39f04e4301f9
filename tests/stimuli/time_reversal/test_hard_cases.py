"""The hard cases of time reversal, each with a reference that shares nothing with the code under test: 50 digits, exact
rational arithmetic, Levy's plate, another Ritz basis, a count of negative pivots. The finger's are in
`test_load.py`, one second-order overload in `test_quantiser.py`.
"""

import math
from fractions import Fraction

import numpy as np
import pytest
from exact_plate import dense_ritz, levy_modes, modal_response, navier_modes, navier_response
from hard_cases import exact_case, hard_case
from mpmath import mp, mpf, sin
from scipy.sparse import csc_array
from scipy.sparse.linalg import eigsh, splu

from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.focusing.focusing import drive, emitted, focus_amplitude, focus_amplitudes
from tactometry.stimuli.time_reversal.focusing.merit import field
from tactometry.stimuli.time_reversal.focusing.modulator import modulate
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.plate.modes import RitzModes, modes_of, values
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.plate.plate import Plate, degrees, ritz
from tactometry.stimuli.time_reversal.plate.propagator import run_impulses
from tactometry.stimuli.time_reversal.plate.ritz import ellipse, pairs, pencil
from tactometry.stimuli.time_reversal.responses.measured import inspect
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

SOURCE, POINT = (0.05, 0.06), (0.121, 0.093)
RATE_HZ, F_MAX_HZ, TAU_S = 20e3, 2.4e3, 3e-3


def learnt(plate, points, *, source=SOURCE, tau_s=TAU_S, rate_hz=RATE_HZ, n_samples=200, f_max_hz=F_MAX_HZ, **more):
    screen = Screen(plate, (PointForce(*source),), Attenuation(tau_s))
    timing = {"rate_hz": rate_hz, "duration_s": n_samples / rate_hz, "f_max_hz": f_max_hz}
    return impulse_responses(screen, points, **timing, **more)


def difference(found, expected):
    """Largest difference over the largest expected value."""
    return np.abs(found - expected).max() / np.abs(expected).max()


def test_square_plate_with_degenerate_modes_is_the_50_digit_sum():
    """f(m, n) = f(n, m): separable modes to rounding, and a Ritz solution whose choice within each pair is its own."""
    square = BOROFLOAT_33.plate(0.21, 0.21, 1.1e-3, "SSSS")
    samples = np.arange(0, 200, 7)
    exact = navier_response(square, SOURCE, POINT, TAU_S, F_MAX_HZ, RATE_HZ, samples)
    omega = [w for _, _, w in navier_modes(square, F_MAX_HZ)]
    assert len(set(omega)) < 0.7 * len(omega)
    off = difference(learnt(square, [POINT]).samples[0, 0, samples], exact)
    hard_case("square plate with degenerate modes", off, 0, 1e-13, against="50 digits", floor=1)
    blocks = ritz(square, F_MAX_HZ)
    found = square.wave_constant_m2_per_s * np.concatenate([block.wavenumber2_per_m2 for block in blocks])
    modes = RitzModes(square, np.sort(found), blocks, np.argsort(found))
    there, here = (values(modes, *place)[:, 0] for place in (SOURCE, POINT))
    response = modal_response(np.sort(found), there, here, square.mass_kg, TAU_S, RATE_HZ, 200)
    hard_case("degenerate modes by Ritz", difference(response[samples], exact), 0, 1e-8, against="50 digits", floor=1)


def test_square_free_plate_answers_the_same_with_x_and_y_exchanged():
    square = BOROFLOAT_33.plate(0.21, 0.21, 1.1e-3, "FFFF")
    straight = learnt(square, [POINT])
    turned = learnt(square, [POINT[::-1]], source=SOURCE[::-1])
    off = difference(turned.samples, straight.samples)
    hard_case("square free plate, x and y exchanged", off, 0, 1e-10, against="itself", floor=1)


@pytest.mark.parametrize("quantity", ["displacement", "velocity"])
@pytest.mark.parametrize("tau_s", [math.inf, 1e-6])
def test_tau_of_infinity_and_of_a_microsecond_are_the_50_digit_sum(tau_s, quantity):
    samples = np.arange(0, 200, 11)
    exact = navier_response(A4_SCREEN, SOURCE, POINT, tau_s, F_MAX_HZ, RATE_HZ, samples, quantity)
    found = learnt(A4_SCREEN, [POINT], tau_s=tau_s, quantity=quantity).samples[0, 0, samples]
    hard_case("plate with tau of 1 us and infinite", difference(found, exact), 0, 2e-13, against="50 digits", floor=1)


def test_a_mode_at_the_nyquist_frequency_is_the_50_digit_sum():
    """Its velocity is +1, -1, +1 ... at the samples: it is there, and above it nothing is."""
    frequency_hz = float(A4_SCREEN.frequencies_hz(3e3)[30])
    timing = {"rate_hz": 2 * frequency_hz, "f_max_hz": frequency_hz}
    samples = np.arange(0, 200, 11)
    for tau_s, quantity in ((math.inf, "velocity"), (TAU_S, "displacement")):
        exact = navier_response(A4_SCREEN, SOURCE, POINT, tau_s, frequency_hz, 2 * frequency_hz, samples, quantity)
        found = learnt(A4_SCREEN, [POINT], tau_s=tau_s, quantity=quantity, **timing).samples[0, 0, samples]
        hard_case("plate with a mode at Nyquist", difference(found, exact), 0, 1e-12, against="50 digits", floor=1)
    with pytest.raises(InvalidParameter, match="above the Nyquist frequency"):
        learnt(A4_SCREEN, [POINT], rate_hz=2 * frequency_hz * (1 - 1e-12), f_max_hz=frequency_hz)


def test_reversal_of_no_sample_and_of_one():
    """One sample of velocity is the sum of the shapes over the mass; of displacement it is 0, which cannot focus."""
    nothing = drive(learnt(A4_SCREEN, [POINT]), 30.0, reversal_s=0.0)
    assert nothing.samples.shape == (1, 0)
    h = learnt(A4_SCREEN, [POINT], quantity="velocity")
    expected = 30 * abs(navier_response(A4_SCREEN, SOURCE, POINT, TAU_S, F_MAX_HZ, RATE_HZ, [0], "velocity")[0])
    one = drive(h, 30.0, reversal_s=1 / RATE_HZ)
    assert one.samples.shape == (1, 1)
    hard_case("reversal of one sample", focus_amplitude(one, h), expected, 1e-13, against="50 digits")
    assert emitted(one, h)[0, 0] == pytest.approx(expected, rel=1e-13)
    with pytest.raises(InvalidParameter, match="zero everywhere"):
        drive(learnt(A4_SCREEN, [POINT]), 30.0, reversal_s=1 / RATE_HZ)


def test_ten_seconds_of_reversal_keep_phase_and_identity():
    """1e6 samples of 78 modes without loss: 1e-12 at the end against 50 digits; the focus is V times the sum of |h|."""
    h = learnt(A4_SCREEN, [POINT], tau_s=math.inf, rate_hz=1e5, n_samples=1_000_000, f_max_hz=5e3)
    modes = modes_of(A4_SCREEN, 5e3)
    weights = values(modes, *SOURCE)[:, 0] * values(modes, *POINT)[:, 0] / A4_SCREEN.mass_kg / 1e5
    mp.dps = 50
    for sample in (499_999, 999_998, 999_999):
        time = mpf(sample) / 100_000
        parts = zip(weights, modes.angular_frequency_rad_per_s, strict=True)
        exact = sum(mpf(float(c)) * sin(mpf(float(w)) * time) / mpf(float(w)) for c, w in parts)
        off = (h.samples[0, 0, sample] - float(exact)) / np.abs(h.samples).max()
        hard_case("reversal over 10 s without loss", off, 0, 1e-12, against="50 digits", floor=1)
    assert focus_amplitude(drive(h, 30.0), h) == pytest.approx(30 * math.fsum(np.abs(h.samples[0, 0])), rel=1e-12)


def test_a_million_steps_of_the_recurrence_drift_by_less_than_1e_10():
    omega = np.array([583.0, 1.2345678e4, 1.5e5])
    taps = np.zeros((3, 1_000_000))
    taps[:, 0] = 1.0
    found = run_impulses(Oscillators(omega, np.zeros(3)), taps, 1e5, np.array([999_999]))[:, 0] * omega
    mp.dps = 50
    exact = [float(sin(mpf(float(w)) * 999_999 / 100_000)) for w in omega]
    hard_case("a million steps of the recurrence", found, exact, 1e-10, against="50 digits", floor=1)


def pencils(plate, f_max_hz, more):
    """Sparse stiffness and mass of each parity block with some degrees more, and the unit of sqrt(eigenvalue) in Hz."""
    p_x, p_y = (degree + more for degree in degrees(plate, f_max_hz))
    rectangle = plate.rectangle
    unit_hz = 4 * plate.wave_constant_m2_per_s / plate.length_m**2 / (2 * math.pi)
    for on_x, on_y in pairs(rectangle, (p_x, p_y)):
        stiffness, mass = pencil(rectangle, on_x, on_y, *ellipse(on_x, on_y, p_x, p_y))
        yield csc_array(stiffness), csc_array(mass), unit_hz


def below_and_near(stiffness, mass, shift):
    """How many eigenvalues lie below a shift (Sylvester: negative pivots of L D L^T), and the four nearest."""
    factors = splu(
        csc_array(stiffness - shift * mass),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    assert np.array_equal(factors.perm_r, factors.perm_c)
    near = eigsh(stiffness, 4, mass, sigma=shift, which="LM", return_eigenvectors=False)
    return np.count_nonzero(factors.U.diagonal() < 0), near


@pytest.mark.slow
def test_2000_free_edge_modes_are_all_there_and_right_to_1e_9():
    """Reference: 8 degrees more, counted by the inertia of K - s M and solved around s by shift and invert."""
    plate, f_max_hz = Plate(0.297, 0.210, 1.1e-3, 70e9, 0.23, 2500.0, "FFFF"), 106.1e3
    found_hz = plate.frequencies_hz(f_max_hz)
    assert len(found_hz) >= 2000
    assert np.all(np.diff(found_hz) >= 0)
    for at_hz in (50e3, f_max_hz):
        n_below, near_hz = 0, []
        for stiffness, mass, unit_hz in pencils(plate, f_max_hz, 8):
            n, near = below_and_near(stiffness, mass, (at_hz / unit_hz) ** 2)
            n_below, near_hz = n_below + n, [*near_hz, *(unit_hz * np.sqrt(near))]
        assert np.count_nonzero(found_hz < at_hz) == n_below
        checked = [f for f in near_hz if f < f_max_hz]
        assert len(checked) >= 5
        off = max(np.abs(found_hz / f - 1).min() for f in checked)
        hard_case("2000 modes with free edges", off, 0, 1e-9, against="negative pivots, 8 more degrees", floor=1)


def one_bit_focus(response, voltage_v=30.0):
    return voltage_v * math.fsum(abs(x) for x in response)


@pytest.mark.parametrize("place", [(0.121, 0.0), (0.2, 0.21)])
def test_focus_on_a_free_edge_is_levys_exact_plate(place):
    """Two edges supported, two free: shapes and frequencies from the roots of a transcendental equation."""
    plate = BOROFLOAT_33.plate(0.297, 0.21, 1.1e-3, "SFSF")
    modes = levy_modes(plate, F_MAX_HZ)
    omega, shapes = zip(*modes, strict=True)
    there, here = ([float(shape(*at)) for shape in shapes] for at in (SOURCE, place))
    exact = modal_response(omega, there, here, plate.mass_kg, TAU_S, RATE_HZ, 200)
    h = learnt(plate, [place])
    assert plate.frequencies_hz(F_MAX_HZ) == pytest.approx(np.divide(omega, 2 * math.pi), rel=1e-11)
    off = difference(h.samples[0, 0], exact)
    hard_case("focus on a free edge", off, 0, 1e-10, against="Levy's plate", floor=1)
    assert focus_amplitude(drive(h, 30.0), h) == pytest.approx(one_bit_focus(exact), rel=1e-10)


@pytest.mark.parametrize("place", [(0.297, 0.21), (0.0, 0.21), (0.297, 0.08)])
def test_focus_on_a_free_corner_and_edge_is_another_ritz_solution(place):
    """All edges free has no closed form: Legendre products, integrals by Gauss's rule, one dense eigenproblem."""
    plate = BOROFLOAT_33.plate(0.297, 0.21, 1.1e-3, "FFFF")
    omega, shapes = dense_ritz(plate, 24)
    kept = omega < 2 * math.pi * F_MAX_HZ
    omega = np.where(np.arange(len(omega)) < 3, 0.0, omega)[kept]
    reference = modal_response(omega, shapes(*SOURCE)[kept], shapes(*place)[kept], plate.mass_kg, TAU_S, RATE_HZ, 200)
    h = learnt(plate, [place])
    assert len(plate.frequencies_hz(F_MAX_HZ)) == np.count_nonzero(kept)
    off = difference(h.samples[0, 0], reference)
    hard_case("focus on a free corner", off, 0, 2e-5, against="another Ritz basis, 24 degrees", floor=1)
    assert focus_amplitude(drive(h, 30.0), h) == pytest.approx(one_bit_focus(reference), rel=2e-5)


@pytest.mark.parametrize("place", [(0.1485, 0.093), (0.1485, 0.105)])
def test_focus_on_node_line_matches_50_digit_sum(place):
    """In the middle every second m (and n) is silent; 4 of 36 modes in all carry the centre."""
    exact = navier_response(A4_SCREEN, SOURCE, place, TAU_S, F_MAX_HZ, RATE_HZ, range(120))
    h = learnt(A4_SCREEN, [place], n_samples=120)
    hard_case("focus on a node line", difference(h.samples[0, 0], exact), 0, 1e-13, against="50 digits", floor=1)
    assert focus_amplitude(drive(h, 30.0), h) == pytest.approx(one_bit_focus(exact), rel=1e-12)
    modes = modes_of(A4_SCREEN, F_MAX_HZ)
    assert not np.abs(values(modes, *place)[:, 0][modes.m % 2 == 0]).max() > 1e-14


NEIGHBOURS = [POINT, (POINT[0] + 1e-4, POINT[1])]


def test_close_foci_match_50_digit_sums():
    """Together they are one focus; with opposite signs the drive is the difference, a thousandth of either."""
    exact = np.array(
        [navier_response(A4_SCREEN, SOURCE, at, TAU_S, F_MAX_HZ, RATE_HZ, range(120)) for at in NEIGHBOURS]
    )
    h = learnt(A4_SCREEN, NEIGHBOURS, n_samples=120)
    together = 30 * exact @ np.where(exact.sum(axis=0) >= 0, 1.0, -1.0)
    assert focus_amplitudes(drive(h, 30.0), h) == pytest.approx(together, rel=1e-12)
    slope = exact[0] - exact[1]
    assert np.abs(slope).max() < 3e-3 * np.abs(exact).max()
    apart = 30 * exact @ slope / np.abs(slope).max()
    found = focus_amplitudes(drive(h, 30.0, Analogue(), weights=[1.0, -1.0]), h)
    hard_case("two foci 0.1 mm apart with opposite signs", found, apart, 1e-9, against="50 digits")
    assert found[0] - found[1] > 0


def test_an_empty_band_is_refused_and_a_band_without_modes_cannot_focus():
    with pytest.raises(InvalidParameter, match="which is empty"):
        Band(5e3, 5e3)
    below_all = 0.9 * float(navier_modes(A4_SCREEN, 100.0)[0][2]) / (2 * math.pi)
    silent = learnt(A4_SCREEN, [POINT], f_max_hz=below_all)
    assert not silent.samples.any()
    with pytest.raises(InvalidParameter, match="zero everywhere"):
        drive(silent, 30.0)
    drawn = field(A4_PROTOTYPE, Signal(np.ones((32, 5)), 1e3, "V"), 4, (np.zeros(2), np.zeros(3)), below_all)
    assert drawn.shape == (2, 3)
    assert not drawn.any()
    exact_case("a band without modes", against="refusal")


def rational_bits(samples, order):
    """The difference equations in exact rational arithmetic."""
    e1 = e2 = Fraction(0)
    bits = []
    for sample in samples:
        y = Fraction(float(sample)) - (e1 if order == 1 else 2 * e1 - e2)
        bits.append(1 if y >= 0 else -1)
        e1, e2 = bits[-1] - y, e1
    return bits


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("peak", [1.0, 0.7, 1e-9])
def test_sigma_delta_matches_exact_rational_arithmetic(order, peak):
    """On multiples of 2^-40, so that doubles are exact too: every decision must agree."""
    grid = 2.0**-40
    wave = np.round(peak * np.sin(0.0137 * np.arange(1500)) / grid) * grid
    stream = modulate(wave[None], order)
    if stream.peak_state < 100:
        assert stream.bits[0].tolist() == rational_bits(wave, order)
    assert stream.overloaded == (order == 2 and peak == 1.0)
    exact_case("sigma-delta at full scale and at 1e-9", against="exact rational arithmetic")


def test_sigma_delta_of_full_scale_direct_current_is_direct_current():
    for order in (1, 2):
        for sign in (1, -1):
            assert (modulate(np.full((1, 200), float(sign)), order).bits == sign).all()


def test_zero_responses_are_refused_or_reported_silent():
    silent = Responses(np.zeros((1, 2, 400)), RATE_HZ)
    with pytest.raises(InvalidParameter, match="zero everywhere"):
        drive(silent, 30.0)
    assert inspect(silent).silent == ((0, 0), (0, 1))
    assert not emitted(Signal(np.ones((2, 7)), RATE_HZ, "V"), silent).any()
    assert not band_limited(silent, Band(100.0, 5e3)).samples.any()
    assert not Analogue().quantise(np.zeros((2, 5)), RATE_HZ).any()
    assert np.all(OneBit().quantise(np.zeros((2, 5)), RATE_HZ) == 1)
    assert abs(SigmaDelta().quantise(np.zeros((1, 400)), RATE_HZ).mean()) < 0.02
    exact_case("responses that are zero everywhere", against="refusal where a focus is wanted")


def test_one_silent_channel_adds_nothing_to_the_focus():
    sounding = learnt(A4_SCREEN, [POINT])
    both = Responses(np.concatenate([sounding.samples, np.zeros_like(sounding.samples)], axis=1), RATE_HZ)
    assert focus_amplitude(drive(both, 30.0), both) == focus_amplitude(drive(sounding, 30.0), sounding)
