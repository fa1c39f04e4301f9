"""Perfect time reversal of raw responses without any time stepping: for sweeps over layouts and foci.

Responses learnt over T and emitted as they are (impulses, no quantiser) leave mode n at the focus instant with
q_n = sum_m I_nm B_nm phi_m(x0) / M^2, B the sum over sources of phi_n phi_m, and
I_nm = integral over 0..T of g_n g_m = Re[G(l_n + l_m*) - G(l_n + l_m)] / (2 w_n w_m), G(z) = (e^{zT} - 1) / z,
in closed form. I depends on the plate, tau and T alone, so that a design costs one product of matrices.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactometry.errors import InvalidParameter
from tactometry.stimuli.time_reversal.attenuation import Attenuation
from tactometry.stimuli.time_reversal.checks import positive, shaped
from tactometry.stimuli.time_reversal.modal_time import Oscillators
from tactometry.stimuli.time_reversal.modes import Modes
from tactometry.stimuli.time_reversal.plate import Plate
from tactometry.stimuli.time_reversal.typed import checked

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@checked
@dataclass(frozen=True, eq=False)
class ClosedReversal:
    """A plate and a reversal time, ready for any sources and foci.

    `overlap` (n_modes, n_modes) holds I_nm in s^3.
    """

    modes: Modes
    overlap: FloatArray

    @classmethod
    def of(cls, plate: Plate, attenuation: Attenuation, f_max_hz: float, reversal_s: float) -> "ClosedReversal":
        """From the modes below `f_max_hz`, which must all oscillate (no rigid body, tau above their 1 / omega)."""
        positive("reversal_s", reversal_s)
        modes = plate.modes(f_max_hz)
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
        shaped("sources", sources, (n_modes, None))
        shaped("focus", focus, (n_modes,))
        heard = sources * focus[:, None]
        summed = np.einsum("nq,nq->n", self.overlap @ heard, sources)
        return np.asarray(summed / self.modes.plate.mass_kg**2)


@checked
def overlap(oscillators: Oscillators, reversal_s: float) -> FloatArray:
    """(n, n): integrals of g_n g_m from 0 to T; `expm1` keeps nearly equal modes without loss exact."""
    positive("reversal_s", reversal_s)
    pole = -oscillators.decay_per_s + 1j * oscillators.split_rad_per_s
    difference = _grown(pole[:, None] + np.conj(pole), reversal_s)
    total = _grown(pole[:, None] + pole, reversal_s)
    return np.asarray((difference - total).real / (2 * np.outer(pole.imag, pole.imag)))


def _grown(z: ComplexArray, time_s: float) -> ComplexArray:
    """(e^{zT} - 1) / z, T for z = 0."""
    safe = np.where(z == 0, 1.0, z)
    return np.where(z == 0, time_s, np.expm1(safe * time_s) / safe)
