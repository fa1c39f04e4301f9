"""Energy: stored in the plate, needed to deform it, and drawn by the switched piezo loads."""

import numpy as np

from tactometry.arguments.checked import checked
from tactometry.arguments.require import not_negative, positive
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal

from ..screen.screen import Screen
from .field import modal_amplitudes

VACUUM_PERMITTIVITY_F_PER_M = 8.8541878128e-12
PZ27_RELATIVE_PERMITTIVITY = 1800.0
"""eps33T / eps0 of PZ27; unverified default."""


@checked
def deformation_energy_j(screen: Screen, signal: Signal, sample: int, f_max_hz: float) -> float:
    """Strain energy of the plate at a sample of a drive: half the sum of M w_n^2 q_n^2, exact for its
    modes.
    """
    q = modal_amplitudes(screen, signal, sample, f_max_hz)
    omega = screen.oscillators(f_max_hz).omega_rad_per_s
    return 0.5 * screen.plate.mass_kg * float(np.sum((omega * q) ** 2))


@checked
def capacitance_f(
    area_m2: float, thickness_m: float, relative_permittivity: float = PZ27_RELATIVE_PERMITTIVITY
) -> float:
    """C = eps A / t of a piezoelectric plate.

    >>> round(capacitance_f(1e-4, 0.3e-3) * 1e9, 2)
    5.31
    """
    positive("capacitance_f", area_m2=area_m2, thickness_m=thickness_m, relative_permittivity=relative_permittivity)
    return relative_permittivity * VACUUM_PERMITTIVITY_F_PER_M * area_m2 / thickness_m


@checked
def switched_power_w(signal: Signal, channel_capacitance_f: float) -> float:
    """Mean electrical power during a switched drive.

    Every change by dV of a capacitance that is charged from a stiff supply dissipates C dV^2 / 2: a +-V
    bridge loses 2 C V^2 per transition, Q C 2 V^2 r_t in all.
    """
    not_negative("switched_power_w", channel_capacitance_f=channel_capacitance_f)
    if signal.samples.shape[1] < 2:
        raise InvalidParameter("signal: found fewer than two samples, expected a drive")
    lost_j = 0.5 * channel_capacitance_f * np.sum(np.diff(signal.samples, axis=1) ** 2)
    return float(lost_j * signal.rate_hz / (signal.samples.shape[1] - 1))
