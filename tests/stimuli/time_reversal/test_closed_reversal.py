"""Perfect reversal in closed form, against a sum over samples."""

import numpy as np
import pytest
from hard_cases import hard_case
from scipy.integrate import quad

from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.focusing.closed_reversal import ClosedReversal, overlap
from tactometry.stimuli.time_reversal.focusing.merit import field, modal_amplitudes, modal_history
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, BOROFLOAT_33
from tactometry.stimuli.time_reversal.plate.modes import values
from tactometry.stimuli.time_reversal.plate.oscillators import Oscillators
from tactometry.stimuli.time_reversal.responses.responses import impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import (
    Attenuation,
)
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import PointForce

T_S = 8e-3


@pytest.mark.parametrize("decay_per_s", [0.0, 300.0])
@pytest.mark.parametrize("omegas", [(2e3, 7e3), (5e3, 5e3), (5e3, 5e3 + 1e-6), (5e3, 5e3 + 1e-9)])
def test_overlap_is_the_integral_of_the_product(decay_per_s, omegas):
    """Equal and nearly equal modes without loss are where a factorised form loses everything."""
    both = Oscillators(np.array(omegas), np.full(2, decay_per_s))

    def product(t: float) -> float:
        g = both.impulse_at(t)[:, 0]
        return float(g[0] * g[1])

    expected = quad(product, 0, T_S, epsabs=0, epsrel=1e-11, limit=400)[0]
    hard_case("overlap of equal and nearly equal modes", overlap(both, T_S)[0, 1], expected, 1e-8, against="quadrature")


def test_amplitude_is_the_energy_of_the_responses():
    """At the focus u = sum over sources of the integral of h^2; a sum over samples comes near it at a high rate."""
    sources, focus, tau_s, f_max_hz = [(0.05, 0.06), (0.2, 0.15), (0.14, 0.03)], (0.121, 0.093), 3e-3, 5e3
    screen = Screen(A4_SCREEN, tuple(PointForce(*p) for p in sources), Attenuation(tau_s))
    rate = 400e3
    h = impulse_responses(screen, [focus], rate_hz=rate, duration_s=T_S, f_max_hz=f_max_hz).samples[0] * rate
    kernel = ClosedReversal.of(A4_SCREEN, Attenuation(tau_s), f_max_hz, T_S)
    shape = values(kernel.modes, *focus)[:, 0]
    amplitudes = kernel.modal_amplitudes(values(kernel.modes, *np.array(sources).T), shape)
    assert shape @ amplitudes == pytest.approx(np.sum(h**2) / rate, rel=1e-5)


def test_field_of_the_closed_form_peaks_at_the_focus():
    kernel = ClosedReversal.of(A4_SCREEN, Attenuation(3e-3), 20e3, T_S)
    focus = (0.121, 0.093)
    sources = A4_PROTOTYPE.modal_forces(20e3)
    x, y = np.linspace(0, 0.297, 100), np.linspace(0, 0.21, 71)
    u = kernel.modes.field(kernel.modal_amplitudes(sources, values(kernel.modes, *focus)[:, 0]), x, y)
    i, j = np.unravel_index(np.argmax(u), u.shape)
    assert (x[i], y[j]) == pytest.approx(focus, abs=4e-3)


def test_rigid_and_overdamped_plates_are_refused():
    free = BOROFLOAT_33.plate(0.297, 0.21, 1.1e-3, "FFFF")
    with pytest.raises(InvalidParameter, match="attenuation: found modes that do not oscillate"):
        ClosedReversal.of(free, Attenuation(3e-3), 2e3, T_S)
    with pytest.raises(InvalidParameter, match="attenuation: found modes that do not oscillate"):
        ClosedReversal.of(A4_SCREEN, Attenuation(1e-6), 2e3, T_S)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: modal_amplitudes(A4_PROTOTYPE, s, 3, 5e3), "signal: found 2 channels, expected 32"),
        (lambda s: modal_amplitudes(A4_PROTOTYPE, s, 3, 5e3, "jerk"), "modal_amplitudes.quantity: found 'jerk'"),
        (
            lambda s: field(A4_PROTOTYPE, Signal(np.ones((32, 4)), 5e4, "V"), -1, (np.zeros(1), np.zeros(1)), 5e3),
            "modal_amplitudes.sample: found -1, expected a whole number, at least 0",
        ),
        (lambda s: modal_history(A4_PROTOTYPE, s, [3, 2], 5e3), "samples: found [3, 2].., expected ascending"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message):
    with pytest.raises(InvalidParameter) as caught:
        call(Signal(np.ones((2, 5)), 50e3, "V"))
    assert str(caught.value).startswith(message)
