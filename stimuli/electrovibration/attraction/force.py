"""Four electrostatic force laws, which differ by a factor near 1000."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from numpy import errstate, isfinite
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import NotNegative, Positive, checked
from tactometry.errors import InvalidParameter

from ...arrays import FloatArray
from ...defaults import VACUUM_PERMITTIVITY_F_PER_M as E0
from ..skin.relaxation import Relaxations, Solution
from ..skin.skin import INSULATOR, Skin
from ..waveforms.pieces import Pieces

if TYPE_CHECKING:
    from .polarity import Polarity

Law = Literal["parallel_plate", "interface", "total_thickness", "sc_layer"]
LAWS: tuple[Law, ...] = get_args(Law)
APPLIED = Relaxations((), (), 1.0)


@checked
@dataclass(frozen=True)
class ForceForm:
    """A force law as ``F = newton_per_v2 u^2``, with u the output of `relaxations` for the applied voltage."""

    relaxations: Relaxations
    newton_per_v2: NotNegative

    def force_n(self, layer_v: FloatArray, polarity: "Polarity | None" = None) -> FloatArray:
        """Return the force (N) of layer voltages u, with their shape."""
        layer_v = require.array("ForceForm.force_n.layer_v", layer_v)
        with errstate(over="ignore"):  # an overflow is rejected below, with the voltage that caused it
            even_n = self.newton_per_v2 * layer_v**2
        if not isfinite(even_n).all():
            raise InvalidParameter(
                f"voltage_v: found a voltage whose force is beyond the range of a double ({abs(layer_v).max():.3g} V "
                "across the layer), expected a lower one"
            )
        if polarity is None:
            return even_n
        from .polarity import Polarity

        require.of_kind("ForceForm.force_n", Polarity, polarity=polarity)
        return polarity.weighted(even_n, layer_v)


@checked
def force_form(law: str | None, skin: Skin, area_m2: NotNegative) -> ForceForm:
    """Apply a force law to a skin and a contact area (m^2, at least 0).

    =================== ==================================================================================
    law                 force
    =================== ==================================================================================
    ``sc_layer``        ``e0 e_sc A (V_sc/d_sc)^2/2``, V_sc across the leaky corneum (Vezzoli, Vardar)
    ``interface``       ``e0 A E^2/2``, field ``E = e_i V_i/d_i`` in a (vanishing) gap (Meyer, Shultz);
                        leakage raises the force at low frequencies
    ``total_thickness`` ``e0 A V^2/(2 S (d_i + d_sc))``, lossless, ``S = d_i/e_i + d_sc/e_sc`` (Strong)
    ``parallel_plate``  ``e0 e_i A V^2/(2 d_i^2)``: the insulator alone, the finger a conductor
    =================== ==================================================================================

    Raises `InvalidParameter` if no law is named, the area is negative, or the law ignores a gap or body that is set.
    """
    check_law(law)
    insulator_m, permittivity = skin.insulator_thickness_m, skin.insulator_permittivity
    if law == "sc_layer":
        return ForceForm(skin.relaxations(area_m2), force_per_square_volt_n(skin, area_m2))
    if law == "interface":
        newton_per_v2 = E0 * area_m2 / 2 * (permittivity / insulator_m) ** 2
        return ForceForm(skin.stack.relaxations(INSULATOR, area_m2), newton_per_v2)

    _check_lossless(str(law), skin)
    if law == "parallel_plate":
        return ForceForm(APPLIED, E0 * permittivity * area_m2 / (2 * insulator_m**2))
    s_m = skin.insulator_equivalent_m + skin.corneum_equivalent_m
    d_m = insulator_m + skin.corneum_thickness_m
    return ForceForm(APPLIED, E0 * area_m2 / (2 * s_m * d_m))


@checked
def electrostatic_force_n(
    voltage_v: ArrayLike,
    *,
    rate_hz: Positive,
    skin: Skin,
    area_m2: float,
    law: Law | None = None,
    polarity: "Polarity | None" = None,
) -> FloatArray:
    """Return the attraction (N) at the samples of a voltage, from rest.

    Raises `InvalidParameter` if a value is outside of its domain, and as in `force_form`.

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
        Must be named; see `force_form`.
    polarity : Polarity or None
        Asymmetry between positive and negative voltages. Default: None, symmetric.

    Returns
    -------
    (..., n_samples) array
        Force at the samples, exact: the recurrence solves the circuit without time stepping.

    >>> step = [100.0, 100.0, 100.0]
    >>> force_n = electrostatic_force_n(step, rate_hz=1e4, skin=Skin(), area_m2=1e-4, law="sc_layer")
    >>> (force_n * 1e3).round(4).tolist()
    [21.2524, 11.268, 5.9743]
    """
    form = force_form(law, skin, area_m2)
    v = require.samples("electrostatic_force_n.voltage_v", voltage_v)
    return form.force_n(form.relaxations.sampled(v, rate_hz), polarity)


@checked
def electrostatic_force_n_at(
    t_s: ArrayLike,
    pieces: Pieces,
    *,
    skin: Skin,
    area_m2: float,
    law: Law | None = None,
    polarity: "Polarity | None" = None,
) -> FloatArray:
    """Return the exact attraction (N) at times within a voltage.

    >>> from tactometry.stimuli.electrovibration import Step
    >>> pieces = Step(duration_s=0.1).pieces(40.0)
    >>> force_n = electrostatic_force_n_at([0.0, 1e-4], pieces, skin=Skin(), area_m2=1e-4, law="sc_layer")
    >>> (force_n * 1e3).round(4).tolist()
    [21.2524, 11.268]
    """
    form = force_form(law, skin, area_m2)
    return form.force_n(Solution(pieces, form.relaxations).at(t_s), polarity)


def check_law(law: str | None) -> None:
    """Raise an error if no law is named."""
    if law is None:
        raise InvalidParameter(
            f"law: found none, expected one of {', '.join(LAWS)}; their forces differ by a factor near 1000, "
            "so name yours"
        )
    require.one_of("law", law, LAWS)


def force_per_square_volt_n(skin: Skin, area_m2: float) -> float:
    """Return ``b = e0 e_sc A/(2 d_sc^2)`` of the ``sc_layer`` law.

    >>> round(force_per_square_volt_n(Skin(), 1e-4), 13)
    1.10677348e-05
    """
    return E0 * skin.corneum_permittivity * area_m2 / (2 * skin.corneum_thickness_m**2)


def _check_lossless(law: str, skin: Skin) -> None:
    for name, neutral in (("gap_m", 0.0), ("body_resistance_ohm", 0.0), ("tissue", None)):
        if getattr(skin, name) != neutral:
            raise InvalidParameter(
                f"law: found {law} with Skin.{name} other than {neutral}, which it has no term for; "
                f"expected {neutral}, or the law interface or sc_layer"
            )
