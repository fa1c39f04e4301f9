"""Force of a periodic voltage on layers whose properties depend on frequency, in its steady state."""

from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments.checked import checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...defaults import VACUUM_PERMITTIVITY_F_PER_M as E0
from ..skin.stack import (
    DispersiveLayer,
    Layer,
    periodic_voltages_v,
    properties_of,
)
from .force import Law, check_law

INSULATOR, CORNEUM = 0, 1


@checked
def periodic_force_n(
    voltage_v: ArrayLike,
    rate_hz: float,
    *,
    insulator: Layer,
    corneum: Layer | DispersiveLayer,
    deeper: Sequence[Layer | DispersiveLayer] = (),
    resistance_ohm: float = 0.0,
    area_m2: float,
    law: Law | None = None,
) -> FloatArray:
    """Attraction (n_samples,) in the periodic steady state of one period (n_samples,) of a voltage.

    Each line of the spectrum is divided between the layers by its own impedances. The voltages, at the samples, then
    give the force: the samples are exact for a voltage without lines above half of `rate_hz`, and so is the spectrum
    of the force if it has none above a quarter of it.

    ============= ====================================================================================
    law           force
    ============= ====================================================================================
    ``interface`` ``e0 A E^2/2``, field ``E = e_i V_i/d_i`` in a vanishing gap; the insulator must not leak
    ``sc_layer``  ``A E D/2``, field ``E = V_sc/d_sc`` and displacement D of the corneum, ``e0 e_sc(f) E``
                  line by line: the law of `force_form` where e_sc is a constant, and for a single line
                  that with the e_sc of its frequency. How the law reads with e_sc(f) is a choice
                  (unverified)
    ============= ====================================================================================

    Raises `InvalidParameter` if the law is not named or has no term for layers that leak, or a value is outside of its
    domain.

    Parameters
    ----------
    voltage_v : (n_samples,) array
        One period; the voltage is the trigonometric polynomial through the samples.
    rate_hz : float
        Samples per second.
    insulator, corneum, deeper
        Layers from the electrode to the body; deeper ones (and a gap) take their share of the voltage.
    resistance_ohm : float
        Body and source.
    area_m2 : float
        Contact area, at least 0.
    law : {"interface", "sc_layer"}
        Must be named.

    >>> tone_v = 100 * np.sin(2 * np.pi * np.arange(64) / 64)
    >>> layers = {"insulator": Layer(1e-6, 3.9), "corneum": Layer(200e-6, 1000.0, 2e4)}
    >>> force_n = periodic_force_n(tone_v, 64 * 60.0, **layers, area_m2=1e-4, law="sc_layer")
    >>> round(float(force_n.mean()) * 1e3, 7)  # of a sine of 60 Hz
    0.1479612
    """
    check_law(law)
    if law not in ("interface", "sc_layer"):
        raise InvalidParameter(f"law: found {law}, which has no term for leakage; expected interface or sc_layer")
    layers = (insulator, corneum, *deeper)
    voltages_v = periodic_voltages_v(voltage_v, rate_hz, layers, resistance_ohm=resistance_ohm, area_m2=area_m2)
    if law == "interface":
        if insulator.thickness_m == 0 or insulator.resistivity_ohm_m < inf:
            raise InvalidParameter(
                f"periodic_force_n.insulator: found {insulator}, expected a thickness above 0 and no leakage: "
                "interface takes the field in the gap from its charge"
            )
        field_v_per_m = insulator.permittivity * voltages_v[INSULATOR] / insulator.thickness_m
        return np.asarray(E0 * area_m2 / 2 * field_v_per_m**2)
    return _sc_layer_n(voltages_v[CORNEUM], corneum, area_m2, rate_hz)


def _sc_layer_n(corneum_v: FloatArray, corneum: Layer | DispersiveLayer, area_m2: float, rate_hz: float) -> FloatArray:
    if corneum.thickness_m == 0:
        raise InvalidParameter("periodic_force_n.corneum: found a thickness of 0 m, expected one above 0")
    field_v_per_m = corneum_v / corneum.thickness_m
    f_hz = np.asarray(np.fft.rfftfreq(corneum_v.size, 1 / rate_hz), dtype=np.float64)
    permittivity, _ = properties_of(corneum, f_hz)
    displacement = E0 * np.fft.irfft(permittivity * np.fft.rfft(field_v_per_m), n=corneum_v.size)
    return np.asarray(area_m2 / 2 * field_v_per_m * displacement)
