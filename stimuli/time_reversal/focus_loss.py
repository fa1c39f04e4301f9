"""Loss of a focus under any contact at one place, from the plate computed once."""

from dataclasses import dataclass

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.arguments.require import shape

from ..arrays import ComplexArray
from .focusing.focusing import Emission, focus_amplitude
from .responses.load import Attached, Receptances, contour
from .responses.responses import Point, Responses, band_limited, values_at
from .screen.screen import Screen


@checked
@dataclass(frozen=True, eq=False)
class FocusLoss:
    """`amplitude_loss` of one contact as a sum over frequencies, exact for a linear contact.

    With the drive fixed, the focus loses the sum of c Z / (1 + H Z): c is what the focus would lose per force, from the
    response of the contact's place to the drive and of the focus to a force there.

    Parameters
    ----------
    s : (n,) array
        Complex frequencies (rad/s) at which stiffness is taken.
    share : (n,) array
        c over the free amplitude (N/m).
    receptance : (n,) array
        H of the contact's place (m/N).
    """

    s: ComplexArray
    share: ComplexArray
    receptance: ComplexArray

    def by(self, stiffness: ComplexArray) -> float:
        """Return the share of the amplitude that a dynamic stiffness (n,) takes."""
        shape("FocusLoss.by.stiffness", stiffness, self.s.shape)
        return float(np.sum(self.share * stiffness / (1 + self.receptance * stiffness)).real)


@checked
def focus_loss(screen: Screen, focus: Point, contact: Attached, emission: Emission) -> FocusLoss:
    """Return the loss at a focus by contacts of the place and shape of `contact`."""
    free = emission.responses(screen, [focus])
    drive = emission.drive(free)
    s, growth, n_fft = contour(free.n_samples, emission.rate_hz)

    # the band filter is even in time: it may act on the reversed drive in place of the responses
    played = band_limited(Responses(drive.samples[None, :, ::-1], emission.rate_hz), emission.band).samples[0]
    weighed = np.conj(np.fft.rfft(played * growth, n_fft)) * (2 / n_fft)
    weighed[:, 0] /= 2
    if n_fft % 2 == 0:
        weighed[:, -1] /= 2

    receptances = Receptances.of(screen.oscillators(emission.f_max_hz), screen.plate.mass_kg, s)
    at = contact.weights(screen, emission.f_max_hz)[:, None]
    to, of = values_at(screen, [focus], emission.f_max_hz), screen.modal_forces(emission.f_max_hz)
    driven = np.sum(weighed * receptances.between(at, of)[0], axis=0)
    share = driven * receptances.between(to, at)[0, 0] / focus_amplitude(drive, free)
    return FocusLoss(s, share, receptances.among(at)[:, 0, 0])
