"""Electrostatic force: four laws of the literature, each by name: they differ by a factor near 1000."""

from collections.abc import Callable, Mapping
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration import require
from tactometry.stimuli.electrovibration.skin import VACUUM_PERMITTIVITY_F_PER_M as E0
from tactometry.stimuli.electrovibration.skin import Skin

Law = Literal["parallel_plate", "interface", "total_thickness", "sc_layer"]
LAWS: tuple[Law, ...] = get_args(Law)


def electrostatic_force_n(
    voltage_v: ArrayLike, *, rate_hz: float, skin: Skin, area_m2: float, law: Law | None = None
) -> NDArray[np.float64]:
    """Attraction (N) between finger and screen at the samples of a voltage, from rest.

    ================== ==================================================================================
    law                force
    ================== ==================================================================================
    ``sc_layer``       ``e0 e_sc A (V_sc/d_sc)^2/2``, V_sc across the leaky corneum (Vezzoli, Vardar)
    ``interface``      ``e0 A E^2/2``, field E in a (vanishing) gap: ``(V - V_sc)/(d_i/e_i + g)`` without body
                       resistance (Meyer, Shultz); leakage raises the force at low frequencies
    ``total_thickness`` ``e0 A V^2/(2 S (d_i + d_sc))``, lossless, ``S = d_i/e_i + d_sc/e_sc`` (Strong)
    ``parallel_plate`` ``e0 e_i A V^2/(2 d_i^2)``: the insulator alone, the finger a conductor
    ================== ==================================================================================

    Parameters
    ----------
    voltage_v : (..., n_samples) array
        Applied voltage, linear between its samples; it jumps from 0 to its first value at time 0.
    rate_hz : float
        Samples per second.
    skin : Skin
    area_m2 : float
        Contact area, at least 0.
    law : {"parallel_plate", "interface", "total_thickness", "sc_layer"}
        Must be named.

    Returns
    -------
    (..., n_samples) array
        Exact at the samples: the recurrence solves the circuit, nothing is stepped.

    Raises
    ------
    InvalidParameter
        If no law is named, a value is outside of its domain, or a law lacks a term for the gap or the body.

    >>> step = np.full(3, 100.0)
    >>> force_n = electrostatic_force_n(step, rate_hz=1e4, skin=Skin(), area_m2=1e-4, law="sc_layer")
    >>> (force_n * 1e3).round(4).tolist()
    [21.2524, 11.268, 5.9743]
    """
    check_law(law)
    require.positive("electrostatic_force_n", rate_hz=rate_hz)
    require.non_negative("electrostatic_force_n", area_m2=area_m2)
    v = require.finite_array("electrostatic_force_n.voltage_v", voltage_v)
    return area_m2 * _PRESSURES[str(law)](v, rate_hz, skin, area_m2)


def check_law(law: str | None) -> None:
    """Refuse a law that is not named."""
    if law is None:
        raise InvalidParameter(
            f"law: found none, expected one of {', '.join(LAWS)}; their forces differ by a factor near 1000, "
            "so name yours"
        )
    require.one_of("law", law, LAWS)


def force_per_square_volt_n(skin: Skin, area_m2: float) -> float:
    """``b`` of ``F = b V_sc^2`` in the ``sc_layer`` law, ``e0 e_sc A/(2 d_sc^2)``.

    >>> round(force_per_square_volt_n(Skin(), 1e-4), 13)
    1.10677348e-05
    """
    return E0 * skin.corneum_permittivity * area_m2 / (2 * skin.corneum_thickness_m**2)


Samples = NDArray[np.float64]


def _sc_layer(v: Samples, rate_hz: float, skin: Skin, area_m2: float) -> Samples:
    return force_per_square_volt_n(skin, 1.0) * corneum_voltage_v(v, rate_hz, skin, area_m2) ** 2


def _interface(v: Samples, rate_hz: float, skin: Skin, area_m2: float) -> Samples:
    if skin.body_resistance_ohm > 0:
        raise InvalidParameter(
            "law: found interface with Skin.body_resistance_ohm above 0, expected 0 here; "
            "use a Stack for the voltage across the gap, or the sc_layer law"
        )
    field = (v - corneum_voltage_v(v, rate_hz, skin, area_m2)) / skin.insulator_equivalent_m
    return E0 / 2 * field**2


def _total_thickness(v: Samples, rate_hz: float, skin: Skin, area_m2: float) -> Samples:
    _check_lossless("total_thickness", skin)
    s_m = skin.insulator_equivalent_m + skin.corneum_equivalent_m
    return E0 * v**2 / (2 * s_m * (skin.insulator_thickness_m + skin.corneum_thickness_m))


def _parallel_plate(v: Samples, rate_hz: float, skin: Skin, area_m2: float) -> Samples:
    _check_lossless("parallel_plate", skin)
    return E0 * skin.insulator_permittivity * v**2 / (2 * skin.insulator_thickness_m**2)


def corneum_voltage_v(v: Samples, rate_hz: float, skin: Skin, area_m2: float) -> Samples:
    """Voltage (..., n_samples) across the stratum corneum, from rest."""
    return skin.relaxations(area_m2).sampled(v, rate_hz)


def _check_lossless(law: str, skin: Skin) -> None:
    for name in ("gap_m", "body_resistance_ohm"):
        if getattr(skin, name) > 0:
            raise InvalidParameter(
                f"law: found {law} with Skin.{name} above 0, which it has no term for; "
                "expected 0, or the law interface or sc_layer"
            )


_PRESSURES: Mapping[str, Callable[[Samples, float, Skin, float], Samples]] = {
    "sc_layer": _sc_layer,
    "interface": _interface,
    "total_thickness": _total_thickness,
    "parallel_plate": _parallel_plate,
}
