"""Layers whose permittivity and resistivity depend on frequency: the periodic steady state."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.annotations import NotNegative, NotNegativeArray, Positive
from tactometry.arguments.checked import checked

from ...arrays import ComplexArray, FloatArray
from ...defaults import VACUUM_PERMITTIVITY_F_PER_M
from .stack import Layer


@checked
@dataclass(frozen=True)
class DispersiveLayer:
    """A slab with a table of properties, log-log between its rows and constant outside of them.

    Raises
    ------
    InvalidParameter
        If the columns differ in length, are not above 0, or the frequencies do not ascend.

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
            expected = f"{len(self.frequencies_hz)} numbers above 0"
            require.expect(fits, f"DispersiveLayer.{name}", column.tolist(), expected)
        rises = (np.diff(self.frequencies_hz) > 0).all()
        require.expect(rises, "DispersiveLayer.frequencies_hz", self.frequencies_hz, "ascending numbers")

    def properties(self, frequency_hz: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Relative permittivity and resistivity (ohm m), of the shape of `frequency_hz` (0: the first
        row)."""
        f_hz = np.maximum(np.asarray(frequency_hz, dtype=np.float64), self.frequencies_hz[0])
        x, rows = np.log(f_hz), np.log(self.frequencies_hz)
        log_permittivity = np.interp(x, rows, np.log(self.permittivities))
        log_resistivity = np.interp(x, rows, np.log(self.resistivities_ohm_m))
        return np.asarray(np.exp(log_permittivity)), np.asarray(np.exp(log_resistivity))


FREQUENCIES_HZ = (1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
STRATUM_CORNEUM = DispersiveLayer(
    200e-6, FREQUENCIES_HZ, (6e3, 4e3, 2e3, 1e3, 7e2, 5e2, 3e2), (2e5, 1.4e5, 6e4, 2e4, 5e3, 1e3, 2e2)
)
"""Unverified default: only its row at 1 kHz is the parameter set P0, the others have the usual trend."""

DEEPER_TISSUE = DispersiveLayer(
    5e-3, FREQUENCIES_HZ, (1e6, 5e5, 1e5, 3e4, 2e4, 1e4, 2e3), (5.0, 4.5, 4.0, 3.5, 3.0, 2.5, 2.0)
)
"""Unverified default: orders of magnitude of a wet tissue."""


@checked
def shares(
    frequency_hz: NotNegativeArray,
    layers: Sequence[Layer | DispersiveLayer],
    *,
    resistance_ohm: NotNegative = 0.0,
    area_m2: NotNegative = 1e-4,
) -> ComplexArray:
    """(n_layers, n_frequencies) complex ratios of the voltage across each layer to the applied one.

    ``Z_j/(R A + sum Z)`` of the impedances of a unit area. At 0 Hz the layers that do not leak hold all
    of the voltage, by their elastances; if all leak, it divides by their resistances.

    Raises `InvalidParameter` if no layer can hold a voltage, or a frequency, resistance or area is negative.
    """
    f_hz = np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))
    holds = np.array([isinstance(layer, DispersiveLayer) or layer.elastance_m2_per_f > 0 for layer in layers])
    expected = "one of thickness and resistivity above 0"
    require.expect(holds.any(), "shares.layers", "none that can hold a voltage", expected)
    ratios = np.zeros((len(layers), f_hz.size), dtype=np.complex128)
    ratios[holds] = _ratios([layers[i] for i in np.flatnonzero(holds)], f_hz, resistance_ohm * area_m2)
    return ratios


def _ratios(layers: Sequence[Layer | DispersiveLayer], f_hz: FloatArray, body_ohm_m2: float) -> ComplexArray:
    admittances = np.array([_admittance(layer, f_hz) for layer in layers])  # (n_layers, n_frequencies)
    # at 0 Hz a layer without a leak passes no current: such layers take all, in the ratio of their elastances
    blocks = (admittances == 0).any(axis=0)
    impedances = np.empty_like(admittances)
    impedances[:, ~blocks] = 1 / admittances[:, ~blocks]
    elastances = np.array([layer.elastance_m2_per_f if isinstance(layer, Layer) else 0.0 for layer in layers], complex)
    impedances[:, blocks] = np.where(admittances[:, blocks] == 0, elastances[:, None], 0)
    in_series = np.where(blocks, 0.0, body_ohm_m2) + impedances.sum(axis=0)
    return np.asarray(impedances / in_series)


@checked
def periodic_voltages_v(
    voltage_v: ArrayLike,
    rate_hz: Positive,
    layers: Sequence[Layer | DispersiveLayer],
    *,
    resistance_ohm: float = 0.0,
    area_m2: float = 1e-4,
) -> FloatArray:
    """(n_layers, n_samples) voltages in the periodic steady state of one period (n_samples,) of a voltage.

    Each bin of the spectrum is multiplied by its share. Sample at 16 times the highest harmonic or more
    before squaring: that doubles the bandwidth.

    >>> plates = (Layer(1e-6), Layer(3e-6))
    >>> periodic_voltages_v([0.0, 4.0, 0.0, -4.0], 100.0, plates).round(9).tolist()
    [[0.0, 1.0, 0.0, -1.0], [0.0, 3.0, 0.0, -3.0]]
    """
    v = require.samples("periodic_voltages_v.voltage_v", voltage_v)
    require.expect(v.ndim == 1, "periodic_voltages_v.voltage_v", f"shape {v.shape}", "one period (n_samples,)")
    f_hz = np.fft.rfftfreq(v.size, 1 / rate_hz)
    ratios = shares(f_hz, layers, resistance_ohm=resistance_ohm, area_m2=area_m2)
    return np.asarray(np.fft.irfft(ratios * np.fft.rfft(v), n=v.size))


def _admittance(layer: Layer | DispersiveLayer, f_hz: FloatArray) -> ComplexArray:
    permittivity, resistivity = properties_of(layer, f_hz)
    capacitive = 2j * np.pi * f_hz * VACUUM_PERMITTIVITY_F_PER_M * permittivity
    return np.asarray((1 / resistivity + capacitive) / layer.thickness_m, dtype=np.complex128)


@checked
def properties_of(layer: Layer | DispersiveLayer, f_hz: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Relative permittivity and resistivity (ohm m) of a layer, constant or from its table."""
    if isinstance(layer, DispersiveLayer):
        return layer.properties(f_hz)
    return np.full_like(f_hz, layer.permittivity), np.full_like(f_hz, layer.resistivity_ohm_m)
