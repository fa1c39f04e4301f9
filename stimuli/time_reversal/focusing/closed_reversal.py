"""Perfect time reversal of raw responses without any time stepping: for sweeps over layouts and foci.

Responses learnt over T and emitted as they are (impulses, no quantiser) leave mode n at the focus instant with
q_n = sum_m I_nm B_nm phi_m(x0) / M^2, B the sum over sources of phi_n phi_m, and
I_nm = integral over 0..T of g_n g_m = Re[G(l_n + l_m*) - G(l_n + l_m)] / (2 w_n w_m), G(z) = (e^{zT} - 1) / z,
in closed form. I depends on the plate, tau and T alone, so that a layout costs one product of matrices, and a new plate
little more: a few operations per pair of modes.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit

from tactometry.arguments.annotations import Positive
from tactometry.arguments.checked import checked
from tactometry.arguments.require import expect, shape
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ..plate.modes import Modes, modes_of
from ..plate.oscillators import Oscillators
from ..plate.plate import Plate
from ..screen.attenuation import Attenuation

SMALL: Final = 1e-2
"""Below this |z T| six terms of (e^{zT} - 1) / (zT) are exact to rounding."""


@checked
@dataclass(frozen=True, eq=False)
class ClosedReversal:
    """A plate and a reversal time, ready for any sources and foci.

    `overlap` (n_modes, n_modes) holds I_nm in s^3.
    """

    modes: Modes
    overlap: FloatArray

    @classmethod
    def of(cls, plate: Plate, attenuation: Attenuation, f_max_hz: float, reversal_s: Positive) -> "ClosedReversal":
        """Build it from the modes below `f_max_hz`, which must oscillate.

        Rigid-body modes, and a tau below 1 / omega of a mode, are refused.
        """
        modes = modes_of(plate, f_max_hz)
        decay = attenuation.rate_per_s(modes.frequency_hz)
        oscillators = Oscillators(modes.angular_frequency_rad_per_s, decay)
        if not oscillators.oscillates.all():
            raise InvalidParameter(
                "attenuation: found modes that do not oscillate (rigid or overdamped), expected a held plate and a "
                "longer tau; use field.modal_amplitudes instead"
            )
        return cls(modes, overlap(oscillators, reversal_s))

    def modal_amplitudes(self, sources: FloatArray, focus: FloatArray) -> FloatArray:
        """(n_modes,): modal displacements at the focus instant per unit impulse (m per N^2 s^2, divided by s).

        Parameters
        ----------
        sources : (n_modes, n_sources) array
            Generalised force of each source on each mode.
        focus : (n_modes,) array
            Shapes at the focus.
        """
        n_modes = len(self.overlap)
        shape("ClosedReversal.modal_amplitudes.sources", sources, (n_modes, None))
        shape("ClosedReversal.modal_amplitudes.focus", focus, (n_modes,))
        heard = sources * focus[:, None]
        summed = np.einsum("nq,nq->n", self.overlap @ heard, sources)
        return np.asarray(summed / self.modes.plate.mass_kg**2)


@checked
def overlap(oscillators: Oscillators, reversal_s: Positive) -> FloatArray:
    """(n, n): integrals of g_n g_m from 0 to T, for modes that oscillate.

    e^{(l_n + l_m*) T} is the product of two numbers per mode, so that no exponential is taken per pair; pairs with a
    z T near 0, where e^{zT} - 1 would cancel, take its power series.
    """
    expect(oscillators.oscillates.all(), "oscillators", "rigid or overdamped modes", "modes that oscillate")
    decay, omega = (
        np.ascontiguousarray(part, float) for part in (oscillators.decay_per_s, oscillators.split_rad_per_s)
    )
    end = np.exp((-decay + 1j * omega) * reversal_s)
    out = np.empty((len(omega), len(omega)))
    _fill(decay, omega, np.ascontiguousarray(end.real), np.ascontiguousarray(end.imag), reversal_s, out)
    return out


@njit(cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _fill(
    decay: FloatArray, omega: FloatArray, real: FloatArray, imag: FloatArray, time_s: float, out: FloatArray
) -> None:
    """Re[G(l_n + l_m*) - G(l_n + l_m)] / (2 w_n w_m) with G(z) = (e^{zT} - 1) / z and e^{l T} = real + i imag."""
    for n in range(len(omega)):
        for m in range(n + 1):
            rate, apart, total = -(decay[n] + decay[m]), omega[n] - omega[m], omega[n] + omega[m]
            rr, ii = real[n] * real[m], imag[n] * imag[m]
            ir, ri = imag[n] * real[m], real[n] * imag[m]
            below = ((rr + ii - 1) * rate + (ir - ri) * apart) / (rate * rate + apart * apart)
            above = ((rr - ii - 1) * rate + (ir + ri) * total) / (rate * rate + total * total)
            out[n, m] = (below - above) / (2 * omega[n] * omega[m])
    # pairs of nearly equal modes again, by the series: their first term was 0/0, or a difference of near equals
    for n in range(len(omega)):
        for m in range(n + 1):
            z = (-(decay[n] + decay[m]) + 1j * (omega[n] - omega[m])) * time_s
            if abs(z.real) + abs(z.imag) < SMALL:
                total = -(decay[n] + decay[m]) + 1j * (omega[n] + omega[m])
                end = (real[n] + 1j * imag[n]) * (real[m] + 1j * imag[m])
                near = time_s * (1 + z / 2 * (1 + z / 3 * (1 + z / 4 * (1 + z / 5 * (1 + z / 6)))))
                out[n, m] = (near - (end - 1) / total).real / (2 * omega[n] * omega[m])
            out[m, n] = out[n, m]
