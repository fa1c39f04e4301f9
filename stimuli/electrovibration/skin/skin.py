"""Electrical model of a finger on an insulated electrode."""

from dataclasses import dataclass
from math import inf, pi
from types import NoneType

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import ComplexArray, FloatArray
from ...defaults import VACUUM_PERMITTIVITY_F_PER_M
from .relaxation import Relaxations
from .stack import Layer, Stack, check_resistivity

INSULATOR, GAP, CORNEUM = 0, 1, 2


@dataclass(frozen=True)
class Skin:
    """Insulator, air gap and stratum corneum (resistor parallel to capacitor) in series with the body.

    The defaults are the parameter set "P0" (`skin` in `stimuli/sources.toml`): usual magnitudes. The resistivity was
    chosen for a cut-off near the 500 Hz that Meyer, Peshkin and Colgate (2013) predicted but did not find.

    Raises `InvalidParameter` if a thickness or permittivity is not above 0, or another value is negative.

    Parameters
    ----------
    insulator_thickness_m : float
        Thickness of the electrode's coating.
    insulator_permittivity : float
        Relative permittivity of the electrode's coating.
    corneum_thickness_m : float
        Thickness of the stratum corneum.
    corneum_permittivity : float
        Relative permittivity of the stratum corneum.
    corneum_resistivity_ohm_m : float
        Resistivity of the stratum corneum: ``inf`` for a lossless skin, 0 for a conductor.
    gap_m : float
        Thickness of the air between insulator and skin.
    body_resistance_ohm : float
        Body and source resistance. Above 0 the waveform of the force depends on the contact area.
    tissue : Layer or None
        Deeper tissue in series. Default: None, tissue that conducts without loss.

    >>> skin = Skin()
    >>> round(skin.k, 9), round(skin.tau_s * 1e6, 6), round(skin.cutoff_hz, 6)
    (0.438202247, 315.209086, 504.91864)
    """

    insulator_thickness_m: float = 1e-6
    insulator_permittivity: float = 3.9
    corneum_thickness_m: float = 200e-6
    corneum_permittivity: float = 1000.0
    corneum_resistivity_ohm_m: float = 2.0e4
    gap_m: float = 0.0
    body_resistance_ohm: float = 0.0
    tissue: Layer | None = None

    def __post_init__(self) -> None:
        require.positive(
            "Skin",
            insulator_thickness_m=self.insulator_thickness_m,
            insulator_permittivity=self.insulator_permittivity,
            corneum_thickness_m=self.corneum_thickness_m,
            corneum_permittivity=self.corneum_permittivity,
        )
        require.not_negative("Skin", gap_m=self.gap_m, body_resistance_ohm=self.body_resistance_ohm)
        require.of_kind("Skin", (Layer, NoneType), tissue=self.tissue)
        check_resistivity("Skin.corneum_resistivity_ohm_m", self.corneum_resistivity_ohm_m)

    @property
    def insulator_equivalent_m(self) -> float:
        """Air thickness with the capacitance of insulator and gap: ``d_i/e_i + g``."""
        return self.insulator_thickness_m / self.insulator_permittivity + self.gap_m

    @property
    def corneum_equivalent_m(self) -> float:
        """Air thickness with the capacitance of the corneum: ``d_sc/e_sc``."""
        return self.corneum_thickness_m / self.corneum_permittivity

    @property
    def k(self) -> float:
        """High-frequency voltage share of the corneum, ``C_i/(C_i + C_sc)``."""
        return self.corneum_equivalent_m / (self.insulator_equivalent_m + self.corneum_equivalent_m)

    @property
    def tau_s(self) -> float:
        """Time constant ``e0 rho (e_sc + d_sc/(d_i/e_i + g))``."""
        permittivity = self.corneum_permittivity + self.corneum_thickness_m / self.insulator_equivalent_m
        return VACUUM_PERMITTIVITY_F_PER_M * self.corneum_resistivity_ohm_m * permittivity

    @property
    def cutoff_hz(self) -> float:
        """Cut-off frequency of the high-pass, ``1/(2 pi tau)``."""
        return 1 / (2 * pi * self.tau_s) if self.tau_s > 0 else inf

    @checked
    def insulator_capacitance_f(self, area_m2: float) -> float:
        """Capacitance of insulator and gap in series."""
        return VACUUM_PERMITTIVITY_F_PER_M * area_m2 / self.insulator_equivalent_m

    @checked
    def corneum_capacitance_f(self, area_m2: float) -> float:
        return VACUUM_PERMITTIVITY_F_PER_M * area_m2 / self.corneum_equivalent_m

    @checked
    def corneum_resistance_ohm(self, area_m2: float) -> float:
        return self.corneum_resistivity_ohm_m * self.corneum_thickness_m / area_m2 if area_m2 > 0 else inf

    @checked
    def response(self, frequency_hz: ArrayLike, area_m2: float = 1e-4) -> ComplexArray:
        """Return the corneum's share of the applied voltage, complex.

        Without body resistance it is ``k tau s/(1 + tau s)`` at any area (1 cm^2: from memory).
        """
        return self.relaxations(area_m2).response(frequency_hz)

    @checked
    def gain(self, frequency_hz: ArrayLike, area_m2: float = 1e-4) -> FloatArray:
        """Return ``|H|``, the magnitude of `response`.

        >>> Skin().gain([60.0, 240.0]).round(6).tolist()
        [0.051708, 0.188118]
        """
        return np.asarray(np.abs(self.response(frequency_hz, area_m2)))

    @property
    def stack(self) -> Stack:
        """Insulator, gap, corneum and tissue in series with the body."""
        layers = (
            Layer(self.insulator_thickness_m, self.insulator_permittivity),
            Layer(self.gap_m),
            Layer(self.corneum_thickness_m, self.corneum_permittivity, self.corneum_resistivity_ohm_m),
        )
        deeper = () if self.tissue is None else (self.tissue,)
        return Stack((*layers, *deeper), self.body_resistance_ohm)

    @checked
    def relaxations(self, area_m2: float) -> Relaxations:
        """Return the relaxations of the corneum's voltage."""
        return self.stack.relaxations(CORNEUM, area_m2)


@checked
def sine_voltage_v(t_s: ArrayLike, frequency_hz: float, voltage_v: float, skin: Skin) -> FloatArray:
    """Return ``V0 |H| (sin(wt + phi) - sin(phi) exp(-t/tau))`` of a sine."""
    check_one_relaxation(skin)
    # the free decay cancels the steady voltage at time 0: the sum begins at rest
    response = complex(skin.response(frequency_hz))
    steady = response * np.exp(2j * np.pi * frequency_hz * np.asarray(t_s, dtype=np.float64))
    return np.asarray(voltage_v * (steady.imag - response.imag * np.exp(-in_taus(t_s, skin))))


def check_one_relaxation(skin: Skin) -> None:
    for name, neutral in (("body_resistance_ohm", 0.0), ("tissue", None)):
        if getattr(skin, name) != neutral:
            raise InvalidParameter(
                f"skin: found a skin with Skin.{name} other than {neutral}, which this formula ignores; "
                f"expected {neutral}, or use Solution or electrostatic_force_n_at"
            )


def in_taus(t_s: ArrayLike, skin: Skin) -> FloatArray:
    """Return the time in units of tau."""
    t = require.not_negative_array("t_s", t_s)
    return t / skin.tau_s if skin.tau_s > 0 else np.where(t == 0, 0.0, inf)
