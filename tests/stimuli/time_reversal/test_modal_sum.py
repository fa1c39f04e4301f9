"""Sums over modes by a non-uniform transform: equal to the matrix product they replace."""

import numpy as np
import pytest
from hard_cases import hard_case
from hypothesis import given, settings, strategies as st
from scipy.special import iv

from tactometry.stimuli.time_reversal.plate import modal_sum
from tactometry.stimuli.time_reversal.plate.modal_sum import FEWEST_MODES, SHORTEST, modal_sums
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators, turns

RATE_HZ = 100e3


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def oscillators(n=200, *, f_low_hz=10.0, f_high_hz=50e3, decay_per_s=300.0):
    omega = 2 * np.pi * np.linspace(f_low_hz, f_high_hz, n)
    return Oscillators(omega, np.broadcast_to(decay_per_s, n).astype(float))


def error(modes, weights, start, stop, quantity="displacement"):
    expected = weights @ modes.impulse(RATE_HZ, start, stop, quantity)
    found = modal_sums(modes, weights, RATE_HZ, start, stop, quantity)
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize("spread", [0.1, 2.0, 20.0])
def test_widely_varying_attenuation_keeps_precision(spread, rng):
    n_samples = 1000
    decay = 400.0 + spread / (n_samples / RATE_HZ) * np.linspace(-0.5, 5.0, 200) ** 2
    modes = oscillators(decay_per_s=decay)
    far = error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, n_samples)
    hard_case("sums over modes whose losses differ widely", far, 0, 1e-13, against="matrix product", floor=1)


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
@pytest.mark.parametrize("n_samples", [SHORTEST, 129, 1000, 1001, 4097])
def test_modal_sum_matches_matrix_product(quantity, n_samples, rng):
    modes = oscillators()
    weights = rng.normal(size=(37, 200)) * modes.omega_rad_per_s
    assert error(modes, weights, 0, n_samples, quantity) < 3e-14


@given(
    seed=st.integers(0, 2**32 - 1),
    start=st.integers(0, 50_000),
    n_samples=st.integers(1, 3000),
    n_modes=st.integers(1, 300),
    tau_s=st.floats(1e-6, 10.0) | st.just(np.inf),
)
@settings(max_examples=60, deadline=None)
def test_modal_sum_matches_matrix_product_for_any_input(seed, start, n_samples, n_modes, tau_s):
    rng = np.random.default_rng(seed)
    omega = np.sort(rng.uniform(0, np.pi * RATE_HZ, n_modes))
    modes = Oscillators(omega, np.full(n_modes, 1 / tau_s))
    weights = rng.normal(size=(3, n_modes))
    expected = weights @ modes.impulse(RATE_HZ, start, start + n_samples)
    found = modal_sums(modes, weights, RATE_HZ, start, start + n_samples)
    off = np.abs(found - expected).max() / max(np.abs(expected).max(), 1e-300)
    hard_case("sums over any modes, tau of 1 us to none", off, 0, 1e-12, against="matrix product", floor=1)


def test_frequencies_at_zero_and_at_nyquist_fold_right(rng):
    modes = oscillators(f_low_hz=1e-3, f_high_hz=RATE_HZ / 2)
    far = error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, 500)
    hard_case("modes at 0 Hz and at Nyquist", far, 0, 1e-13, against="matrix product", floor=1)


def test_frequency_dependent_attenuation_keeps_precision(rng):
    modes = oscillators(decay_per_s=300.0 * np.linspace(0.8, 1.2, 200))
    assert error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, 700) < 1e-13


def test_creeping_and_fast_modes_are_added_exactly(rng):
    decay = np.full(200, 300.0)
    decay[[0, 7, 50]] = 1e5, 1e9, 5e3
    modes = oscillators(decay_per_s=decay)
    far = error(modes, rng.normal(size=(3, 200)) * modes.omega_rad_per_s, 0, 700)
    hard_case("modes that creep", far, 0, 1e-13, against="matrix product", floor=1)


def test_small_sums_use_the_plain_product(monkeypatch, rng):
    def never(*arguments):
        raise AssertionError(arguments)

    monkeypatch.setattr(modal_sum, "_transform", never)
    modal_sums(oscillators(FEWEST_MODES - 1), rng.normal(size=(2, FEWEST_MODES - 1)), RATE_HZ, 0, 1000)
    modal_sums(oscillators(), rng.normal(size=(2, 200)), RATE_HZ, 0, SHORTEST - 1)


def test_modal_sum_writes_to_given_output(rng):
    modes, weights, out = oscillators(), rng.normal(size=(40, 200)), np.zeros((40, 600))
    modal_sums(modes, weights, RATE_HZ, 0, 400, out=out[:, 100:500])
    assert np.array_equal(out[:, 100:500], modal_sums(modes, weights, RATE_HZ, 0, 400))
    assert not out[:, :100].any()
    assert not out[:, 500:].any()


def test_modes_in_any_order_have_one_sum(rng):
    modes, weights, order = oscillators(), rng.normal(size=(3, 200)), rng.permutation(200)
    expected = modal_sums(modes, weights, RATE_HZ, 0, 700)
    np.testing.assert_array_equal(modal_sums(modes.of(order), weights[:, order], RATE_HZ, 0, 700), expected)


@pytest.mark.parametrize("away", [0.0, 1e-3, 0.3])
def test_the_kernel_is_a_bessel_function(away):
    grid, bins = modal_sum._Grid.of(1750), np.linspace(-8, 8, 401) + 1j * away
    expected = iv(0, grid.beta * np.sqrt(1 - (bins / 8) ** 2))
    np.testing.assert_allclose(grid.kernel(bins), expected, rtol=0, atol=2e-14 * np.abs(expected).max())


def test_turns_hold_twice_the_digits_of_a_double():
    mpmath = pytest.importorskip("mpmath")
    omega = np.array([1.0, 12345.678, 3.1e5])
    high, low = turns(omega, 1_000_003.0, 250e3)
    with mpmath.workprec(200):
        for w, h, rest in zip(omega, high, low, strict=True):
            exact = mpmath.mpf(float(w)) * 1_000_003 / 250_000 / (2 * mpmath.pi)
            off = float((mpmath.mpf(float(h)) + mpmath.mpf(float(rest)) - exact) / exact)
            hard_case("turns as a pair of doubles", off, 0, 1e-30, against="60 digits", floor=1)
