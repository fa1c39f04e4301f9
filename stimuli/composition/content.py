"""Signal content that effects add to a scene, which sets its sampling."""

from dataclasses import dataclass, fields
from math import inf


@dataclass(frozen=True)
class VoltageContent:
    """Rates and frequencies in a voltage and the force that it causes.

    Parameters
    ----------
    added_hz : float
        Frequency added to that of the voltage.
    carrier_hz : float
        Carrier frequency; 0 without a carrier.
    envelope_rad_per_s, kinks_rad_per_s : float
        Slope of an envelope at its zeros, where it has a kink: an envelope of the tone alone, and one of the whole
        voltage.
    constant : float
        Constant voltage added to the tone, divided by the peak of the tone.
    swing_rad_per_s : float
        Angular frequency of the free oscillation of the finger pad.
    resistivity_ohm_m : float
        Resistivity of the corneum.
    gap_m : float
        Thickness of the air gap.
    bare_kinks : float
        Share of the voltage's kinks that the skin passes on unchanged.
    steepest_db_per_hz : float
        Largest change of a component's felt level per hertz of its frequency.
    """

    added_hz: float = 0.0
    carrier_hz: float = 0.0
    envelope_rad_per_s: float = 0.0
    kinks_rad_per_s: float = 0.0
    constant: float = 0.0
    swing_rad_per_s: float = 0.0
    resistivity_ohm_m: float = inf
    gap_m: float = 0.0
    bare_kinks: float = 0.0
    steepest_db_per_hz: float = 0.0

    def __add__(self, other: "VoltageContent") -> "VoltageContent":
        """Add the content of two effects; the lower resistivity counts."""
        both = {field.name: getattr(self, field.name) + getattr(other, field.name) for field in fields(self)}
        both["resistivity_ohm_m"] = min(self.resistivity_ohm_m, other.resistivity_ohm_m)
        return VoltageContent(**both)


@dataclass(frozen=True)
class PlateContent:
    """Properties of a plate's motion that set its time span and modes.

    Parameters
    ----------
    weakening : float
        Factor by which the reading is smaller than that of a single plain focus; errors are relative to the reading.
    tau_s : float
        Time constant at the top of the band.
    ringing_s : float
        How long the plate rings after the emission.
    train_s : float
        Time by which the emission exceeds the reversal time.
    places_m : tuple of pairs of float
        Points besides the focus at which the motion is read.
    reach_m : float
        Largest distance from the centre of a transducer to its outline.
    load : float
        Impedance of the load on the plate, divided by that of the infinite plate.
    reading : float
        Truncation error of the modes under a finger, divided by that at the focus.
    most_ritz_modes : float
        Largest number of Ritz modes, for edges that need them.
    """

    weakening: float = 1.0
    tau_s: float = inf
    ringing_s: float = 0.0
    train_s: float = 0.0
    places_m: tuple[tuple[float, float], ...] = ()
    reach_m: float = 0.0
    load: float = 0.0
    reading: float = 1.0
    most_ritz_modes: float = inf

    def __add__(self, other: "PlateContent") -> "PlateContent":
        """Combine the content of two effects."""
        return PlateContent(
            weakening=self.weakening * other.weakening,
            tau_s=min(self.tau_s, other.tau_s),
            ringing_s=self.ringing_s + other.ringing_s,
            train_s=self.train_s + other.train_s,
            places_m=self.places_m + other.places_m,
            reach_m=max(self.reach_m, other.reach_m),
            load=self.load + other.load,
            reading=self.reading * other.reading,
            most_ritz_modes=min(self.most_ritz_modes, other.most_ritz_modes),
        )
