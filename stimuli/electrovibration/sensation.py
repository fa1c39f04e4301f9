"""What a sliding finger feels of a voltage: from the samples to a sensation level."""

from dataclasses import dataclass, field
from functools import lru_cache
from math import inf
from typing import Literal

import numpy as np

from tactometry.arguments import require
from tactometry.arguments.annotations import Positive
from tactometry.arguments.checked import checked
from tactometry.contact import Contact
from tactometry.signal import Signal

from ..arrays import FloatArray
from ..perception.channels import BEST_HZ, THRESHOLD_M, as_at_250_hz, highest_level_db
from ..perception.detection import Components, components
from .attraction.contact_area import ContactArea, PowerLawArea
from .attraction.force import Law, electrostatic_force_n
from .attraction.polarity import Polarity
from .motion.coulomb_friction import CoulombFriction
from .motion.friction_lag import FrictionLag
from .motion.skin_mobility import SkinMobility, displacement
from .skin.skin import Skin

N_CACHED = 512
FINER = 2
HIGH_SHARE = 1e-4
"""Of the power: below it, what aliases is 40 dB under the rest."""
Criterion = Literal["absolute", "fraction"]


@checked
@dataclass(frozen=True)
class ElectrovibrationSensation:
    """Sensation level of the friction that a voltage causes under a sliding finger.

    Voltage, corneum, electrostatic force (`law`), friction, lag of friction, displacement of the skin, thresholds of
    the receptor channels: the level is that of the component furthest above the lowest of them.

    Parameters
    ----------
    skin, law, area, friction
        The electrical model, the force law by name, contact area and friction against normal force. The law is an
        unverified default: the four in print differ by a factor near 1000.
    lag : FrictionLag or None
        First-order lag of friction, on by default; None leaves it out.
    mobility : SkinMobility
        How far the skin moves under the friction.
    reference_m : float
        Amplitude of the skin's displacement at the detection threshold, at 250 Hz: 0.1 um, an unverified default. No
        voltage is put in: with these values a square-root carrier of 240 Hz (1.5 N, 50 mm/s) is felt from 31 V peak.
    criterion : {"absolute", "fraction"}
        Whether `reference_m` holds at any normal force, or at 1 N and in proportion to it at others, so that a
        fixed fraction of the friction is detected. With areas that grow as ``F^m`` the threshold then changes with
        force as ``-10 m log10 F`` dB or as ``10 (1 - m) log10 F`` dB.
    reference_force_n : float, optional
        Amplitude of the friction at threshold, at 250 Hz, in place of `reference_m`: in study files written before
        thresholds were those of the skin.
    polarity : Polarity or None
        An asymmetry between positive and negative voltages; None, the default, is none.

    Examples
    --------
    >>> from tactometry.stimuli.electrovibration import AmplitudeModulated
    >>> model = ElectrovibrationSensation()
    >>> signal = AmplitudeModulated(frequency_hz=240.0).at(29.8)
    >>> abs(model.sensation_db(signal, Contact(force_n=1.5, speed_m_per_s=0.05))) < 0.1
    True
    >>> model.sensation_db(signal, Contact(force_n=1.5))
    -inf
    """

    skin: Skin = field(default_factory=Skin)
    law: Law = "sc_layer"
    area: ContactArea = field(default_factory=PowerLawArea)
    friction: CoulombFriction = field(default_factory=CoulombFriction)
    lag: FrictionLag | None = field(default_factory=FrictionLag)
    mobility: SkinMobility = field(default_factory=SkinMobility)
    reference_m: Positive = THRESHOLD_M
    criterion: Criterion = "absolute"
    polarity: Polarity | None = None
    reference_force_n: Positive | None = None

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        """Sensation level (dB) of a voltage under a finger; ``-inf`` in silence, at rest and without contact.

        It comes from the samples, ramps included. The lag acts on each component in its steady state.

        Raises
        ------
        InvalidParameter
            If the signal is not one channel in volt.
        """
        channels = f"{len(signal.samples)} channels in {signal.unit!r}"
        one_in_volt = signal.unit == "V" and len(signal.samples) == 1
        require.expect(one_in_volt, "sensation_db.signal", channels, "one channel in volt ('V')")
        if contact.speed_m_per_s == 0 or contact.force_n == 0:
            return -inf
        area_m2 = float(self.area.area_m2(contact.force_n))
        parts = _force_components(signal, self.skin, area_m2, self.law, self.polarity)
        skin = displacement(self.mobility, self._friction(parts, contact), contact.force_n)
        return highest_level_db(skin, self.threshold_m(contact.force_n))

    def threshold_m(self, force_n: float) -> float:
        """Displacement at threshold, at 250 Hz, of a finger under a normal force."""
        relative = force_n if self.criterion == "fraction" else 1.0
        if self.reference_force_n is None:
            return relative * self.reference_m
        return relative * self.reference_force_n * float(self.mobility.gain_m_per_n(BEST_HZ, force_n))

    def _friction(self, parts: Components, contact: Contact) -> Components:
        friction = self.friction.at_speed(contact.speed_m_per_s)
        modulation_n = friction.modulation_n(parts.amplitudes, contact.force_n)
        if self.lag is not None:
            modulation_n = modulation_n * self.lag.gain(parts.frequencies_hz, contact.speed_m_per_s)
        return Components(parts.frequencies_hz, modulation_n)


def _force_components(signal: Signal, skin: Skin, area_m2: float, law: Law, polarity: Polarity | None) -> Components:
    """Components (N) of the electrostatic force, weighed `as_at_250_hz`; without body resistance the
    area is only a factor."""
    if skin.body_resistance_ohm > 0:
        return _cached_components(signal, skin, area_m2, law, polarity)
    unit = _cached_components(signal, skin, 1.0, law, polarity)
    return Components(unit.frequencies_hz, area_m2 * unit.amplitudes)


@lru_cache(maxsize=N_CACHED)
def _cached_components(signal: Signal, skin: Skin, area_m2: float, law: Law, polarity: Polarity | None) -> Components:
    voltage_v, rate_hz = _room_for_the_square(signal.samples[0], signal.rate_hz)
    force_n = electrostatic_force_n(voltage_v, rate_hz=rate_hz, skin=skin, area_m2=area_m2, law=law, polarity=polarity)
    return as_at_250_hz(components(force_n, rate_hz))


def _room_for_the_square(voltage_v: FloatArray, rate_hz: float) -> tuple[FloatArray, float]:
    """Samples and rate; `FINER` times as many (band-limited) if there is power above a quarter of the rate.

    The square has twice the bandwidth: the force of a carrier of 9.9 kHz at 20 kHz would seem to vibrate at 200 Hz.
    """
    lines, n = np.fft.rfft(voltage_v), voltage_v.size
    power = lines.real**2 + lines.imag**2
    if n < 4 or power[lines.size // 2 :].sum() <= HIGH_SHARE * power.sum():
        return voltage_v, rate_hz
    lines[n // 2 :] *= 1.0 if n % 2 else 0.5
    return FINER * np.fft.irfft(lines, n=FINER * n), FINER * rate_hz
