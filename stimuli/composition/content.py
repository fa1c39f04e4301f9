"""Content that effects add to a scene and that it must resolve."""

from dataclasses import dataclass, fields
from math import inf


@dataclass(frozen=True)
class VoltageContent:
    """Content of a voltage and of the force that it causes.

    Parameters
    ----------
    added_hz : float
        Frequency that is added to that of the voltage.
    carrier_hz : float
        Frequency of a carrier, 0 of none.
    envelope_rad_per_s, kinks_rad_per_s : float
        How fast an envelope goes through its zeros, where it has a kink: one of the tone alone, and one of all of it.
    constant : float
        The constant voltage added to the tone, over the peak of the tone.
    swing_rad_per_s : float
        How fast a finger pad swings freely.
    resistivity_ohm_m : float
        Of the corneum.
    gap_m : float
        Of air.
    bare_kinks : float
        Share of the kinks of the voltage that the skin passes on as they are.
    steepest_db_per_hz : float
        How fast what is felt of a component changes with its frequency at most.
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
    """Content of the motion of a plate.

    Parameters
    ----------
    weakening : float
        How much smaller than the plainest focus the reading is that errors are relative to.
    tau_s : float
        Time constant at the top of the band.
    ringing_s : float
        How long the plate sounds after its emission.
    train_s : float
        By how much an emission is longer than the reversal time.
    places_m : tuple of pairs of float
        Where the motion is read in addition to the focus.
    reach_m : float
        From the centre of a transducer to its outline.
    load : float
        Impedance of what loads the plate, over that of the infinite plate.
    reading : float
        How much more of what the modes leave out a finger feels than the focus shows.
    most_ritz_modes : float
        That can be had of edges that need them.
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
