"""Leaky layers in series between electrode and body."""

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, inf
from struct import pack, unpack

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.arguments.constraints import DOMAINS

from ...arrays import ComplexArray, FloatArray
from ...defaults import VACUUM_PERMITTIVITY_F_PER_M
from .relaxation import Relaxations

LARGEST = 1e280


SMALLEST_OHM_M, LARGEST_OHM_M = DOMAINS["_ohm_m"]


def check_resistivity(where: str, found: object) -> None:
    """Raise an error unless a resistivity is 0, infinite or within bounds."""
    number = found if isinstance(found, int | float) and not isinstance(found, bool) else -1
    expected = f"0 (a conductor) or a number from {SMALLEST_OHM_M:g} to {LARGEST_OHM_M:g} (inf: lossless)"
    require.expect(number in (0, inf) or SMALLEST_OHM_M <= number <= LARGEST_OHM_M, where, repr(found), expected)


@dataclass(frozen=True)
class Layer:
    """A homogeneous layer of the circuit.

    Parameters
    ----------
    thickness_m : float
        Thickness of the layer, above 0.
    permittivity : float
        Relative permittivity: 1 for air.
    resistivity_ohm_m : float
        Resistivity: ``inf`` for no leakage, 0 for a conductor.

    >>> round(Layer(200e-6, 1000.0, 2e4).rate_per_s, 3)
    5647.045
    """

    thickness_m: float
    permittivity: float = 1.0
    resistivity_ohm_m: float = inf

    def __post_init__(self) -> None:
        require.not_negative("Layer", thickness_m=self.thickness_m)
        require.positive("Layer", permittivity=self.permittivity)
        check_resistivity("Layer.resistivity_ohm_m", self.resistivity_ohm_m)

    @property
    def elastance_m2_per_f(self) -> float:
        """Inverse capacitance of a unit area, ``d/(e0 e)``; 0 for a conductor."""
        conducts = self.resistivity_ohm_m == 0
        return 0.0 if conducts else self.thickness_m / (VACUUM_PERMITTIVITY_F_PER_M * self.permittivity)

    @property
    def rate_per_s(self) -> float:
        """Rate of self-discharge, ``1/(e0 e rho)``; 0 without leakage."""
        if self.resistivity_ohm_m == 0:
            return inf
        return 1 / (VACUUM_PERMITTIVITY_F_PER_M * self.permittivity * self.resistivity_ohm_m)


@checked
@dataclass(frozen=True)
class Stack:
    """Leaky layers in series from the electrode to the body, and a series resistance (body and source).

    The voltage share of layer j is ``Z_j/(R + sum Z)`` with ``Z_j = s_j/(A (p + r_j))``, s the elastance and r the rate
    of a layer. It is a sum of real relaxations, whose rates interlace those of the layers.

    Raises `InvalidParameter` if no layer can carry a voltage, or the resistance is negative.

    >>> stack = Stack((Layer(1e-6, 3.9), Layer(200e-6, 1000.0, 2e4)))
    >>> result = stack.relaxations(1, area_m2=1e-4)
    >>> round(result.gains[0], 9), round(1e6 / result.rates_per_s[0], 6)
    (0.438202247, 315.209086)
    """

    layers: tuple[Layer, ...]
    resistance_ohm: NotNegative = 0.0

    def __post_init__(self) -> None:
        holds = any(layer.elastance_m2_per_f > 0 for layer in self.layers)
        expected = "a layer of thickness and resistivity above 0"
        require.expect(holds, "Stack.layers", "no layer that can carry a voltage", expected)

    def relaxations(self, index: int, area_m2: float) -> Relaxations:
        """Return the relaxations of layer `index`'s voltage share at an area (m^2)."""
        require.not_negative("Stack", area_m2=area_m2)
        require.one_of("Stack.index", index, range(len(self.layers)))
        rates = sorted({layer.rate_per_s for layer in self.layers if layer.elastance_m2_per_f > 0})
        sums = [sum(layer.elastance_m2_per_f for layer in self.layers if layer.rate_per_s == rate) for rate in rates]
        layer, series = self.layers[index], _Series(tuple(rates), tuple(sums), self.resistance_ohm * area_m2)
        if layer.elastance_m2_per_f == 0:
            return Relaxations((), ())
        group = series.rates_per_s.index(layer.rate_per_s)
        share, poles = layer.elastance_m2_per_f / series.elastances[group], series.poles()
        gains = tuple(share * series.gain(pole, group) for pole in poles)
        return Relaxations(gains, tuple(pole.rate_per_s for pole in poles), share * series.dc_gain(group))

    def response(self, frequency_hz: ArrayLike, index: int, area_m2: float) -> ComplexArray:
        """Return layer `index`'s complex share of the applied voltage."""
        return self.relaxations(index, area_m2).response(frequency_hz)


@dataclass(frozen=True)
class _Pole:
    """A relaxation rate and its exact distances from the group rates."""

    rate_per_s: float
    distances_per_s: tuple[float, ...]


@dataclass(frozen=True)
class _Series:
    """Groups of layers by ascending rate, and a resistance in series."""

    rates_per_s: tuple[float, ...]
    elastances: tuple[float, ...]
    resistance_ohm_m2: float

    def dc_gain(self, group: int) -> float:
        if self.rates_per_s[0] == 0:  # layers without leakage carry all of a constant voltage
            return 1.0 if group == 0 else 0.0
        resistances = [s / r for s, r in zip(self.elastances, self.rates_per_s, strict=True)]
        return resistances[group] / (self.resistance_ohm_m2 + sum(resistances))

    def gain(self, pole: _Pole, group: int) -> float:
        """Return a of ``a p/(p + rate)`` in a group's voltage.

        It is the residue of ``[s_g/(p + r_g)]/[R + sum s_h/(p + r_h)]`` over ``-rate``.
        """
        scaled = [s * pole.rate_per_s / d for s, d in zip(self.elastances, pole.distances_per_s, strict=True)]
        total = sum(x * (pole.rate_per_s / d) for x, d in zip(scaled, pole.distances_per_s, strict=True))
        return scaled[group] / total

    def poles(self) -> list[_Pole]:
        """Return the zeros of ``R + sum_h s_h/(r_h - rate)``."""
        poles = [self._between(low) for low in range(len(self.rates_per_s) - 1)]
        # a smaller resistance counts as none: its pole would overflow
        if self.resistance_ohm_m2 > 2 * sum(self.elastances) / LARGEST:
            poles.append(self._from(len(self.rates_per_s) - 1, 2 * sum(self.elastances) / self.resistance_ohm_m2))
        return poles

    def _between(self, low: int) -> _Pole:
        """Return the zero between two rates, measured from the nearer one."""
        # a pole may be so close to a rate that only its distance from that rate is precise
        half = (self.rates_per_s[low + 1] - self.rates_per_s[low]) / 2
        offsets = [rate - self.rates_per_s[low] for rate in self.rates_per_s]
        at_half = self.resistance_ohm_m2 + sum(s / (o - half) for s, o in zip(self.elastances, offsets, strict=True))
        return self._from(low, half) if at_half >= 0 else self._from(low + 1, -half)

    def _from(self, origin: int, reach: float) -> _Pole:
        """Return the zero between ``rates[origin]`` and ``rates[origin] + reach``."""
        offsets = [rate - self.rates_per_s[origin] for rate in self.rates_per_s]
        others = [(s, o) for i, (s, o) in enumerate(zip(self.elastances, offsets, strict=True)) if i != origin]

        # the secular function times the shift, which removes the pole at the origin
        def regular(shift: float) -> float:
            return -self.elastances[origin] + shift * (self.resistance_ohm_m2 + sum(s / (o - shift) for s, o in others))

        # Rounding may move a zero at `reach` beyond it.
        root = reach if regular(reach) <= 0 else _zero(regular, reach)
        return _Pole(self.rates_per_s[origin] + root, tuple(offset - root for offset in offsets))


def _zero(function: Callable[[float], float], reach: float) -> float:
    """Return the sign change of a function between 0 and `reach`, exactly.

    The function is below 0 at 0 and above 0 at `reach`.

    It bisects the floating-point numbers in between instead of the distance, so that even the smallest root takes 63
    steps and is exact to the last digit. Importing a library's search takes longer than computing a scene.

    >>> _zero(lambda x: x * x - 2, 2.0), _zero(lambda x: -1e-300 - x, -1.0)
    (1.4142135623730951, -1e-300)
    """
    below, beyond = 0, unpack("<q", pack("<d", abs(reach)))[0]  # ranks among all floating-point numbers
    while beyond - below > 1:
        middle = (below + beyond) // 2
        value = function(copysign(_number(middle), reach))
        if value == 0:
            return copysign(_number(middle), reach)
        below, beyond = (middle, beyond) if value < 0 else (below, middle)
    return copysign(_number(beyond), reach)


def _number(place: int) -> float:
    number: float = unpack("<d", pack("<q", place))[0]
    return number


@checked
@dataclass(frozen=True)
class DispersiveLayer:
    """A layer with a table of properties, interpolated log-log and constant outside the table.

    Raises `InvalidParameter` if the columns differ in length, are not above 0, or the frequencies do not ascend.

    >>> layer = DispersiveLayer(200e-6, (10.0, 1000.0), (1e4, 1e2), (1e5, 1e3))
    >>> [round(float(values), 6) for values in layer.properties(100.0)]
    [1000.0, 10000.0]
    """

    thickness_m: Positive
    frequencies_hz: tuple[float, ...]
    permittivities: tuple[float, ...]
    resistivities_ohm_m: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("frequencies_hz", "permittivities", "resistivities_ohm_m"):
            column = np.asarray(getattr(self, name), dtype=np.float64)
            fits = column.shape == (len(self.frequencies_hz),) and column.size > 0 and (column > 0).all()
            expected = f"{len(self.frequencies_hz)} numbers above 0, one per frequency"
            require.expect(fits, f"DispersiveLayer.{name}", column.tolist(), expected)
        rises = (np.diff(self.frequencies_hz) > 0).all()
        require.expect(rises, "DispersiveLayer.frequencies_hz", self.frequencies_hz, "ascending numbers")

    def properties(self, frequency_hz: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return relative permittivity and resistivity (ohm m) at frequencies."""
        f_hz = np.maximum(np.asarray(frequency_hz, dtype=np.float64), self.frequencies_hz[0])
        x, rows = np.log(f_hz), np.log(self.frequencies_hz)
        log_permittivity = np.interp(x, rows, np.log(self.permittivities))
        log_resistivity = np.interp(x, rows, np.log(self.resistivities_ohm_m))
        return np.asarray(np.exp(log_permittivity)), np.asarray(np.exp(log_resistivity))


FREQUENCIES_HZ = (1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
STRATUM_CORNEUM = DispersiveLayer(
    200e-6, FREQUENCIES_HZ, (6e3, 4e3, 2e3, 1e3, 7e2, 5e2, 3e2), (2e5, 1.4e5, 6e4, 2e4, 5e3, 1e3, 2e2)
)
"""Unverified default: only the row at 1 kHz is the parameter set P0; the others follow the usual trend."""

DEEPER_TISSUE = DispersiveLayer(
    5e-3, FREQUENCIES_HZ, (1e6, 5e5, 1e5, 3e4, 2e4, 1e4, 2e3), (5.0, 4.5, 4.0, 3.5, 3.0, 2.5, 2.0)
)
"""Unverified default: orders of magnitude for wet tissue."""
