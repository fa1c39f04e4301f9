"""Edges other than simply supported: modes by Rayleigh and Ritz.

Polynomials of degree p err in a frequency by ``c/p^4``, by far the most where a free edge meets a clamped one. Learning
and emission use the same model, so that only a part of the resulting phase error over the reversal time is visible. The
constants are fitted to Ritz modes of 25 to 40 more degrees, with a margin, and checked by tests.
"""

from dataclasses import dataclass
from math import pi

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ...composition.content import PlateContent
from ...composition.effect import Alteration, Demand, Size, Surroundings
from ..stages.truncation import cut_of

OF_SINGULAR_CORNER, OF_OTHER_CORNERS = 10.0, 0.05
"""Relative error of the frequencies times the fourth power of the degree."""
MOST_RITZ_MODES = 6000
OF_MODES = 2000.0
"""Operations divided by the squared number of functions in a block; 1900 to 2600 were measured at 1200 to 3400
functions."""
SEEN = 0.05
"""Part of the phase error that is visible in an output."""


@dataclass(frozen=True)
class Edges(Alteration):
    """Edges of a plate that are not all simply supported.

    Parameters
    ----------
    boundary : str
        Four letters of S (supported), C (clamped) and F (free) other than ``SSSS``, for the edges x = 0, y = 0, x =
        length, y = width.
    """

    kind = "edges"
    in_signal = True
    reads, gives = ("plate",), "plate"

    boundary: str

    def __post_init__(self) -> None:
        found, expected = repr(self.boundary), "four letters of S, C, F, such as 'FFFF'"
        expect(len(self.boundary) == 4 and set(self.boundary) <= set("SCF"), "Edges.boundary", found, expected)
        if self.boundary == "SSSS":
            raise InvalidParameter(
                "Edges.boundary: found 'SSSS', the default of a plate, expected other edges; remove the effect"
            )

    def size(self, demand: Demand) -> Size:
        from ...time_reversal.plate.plate import degrees_called_for

        error = self.error(demand)
        if error > demand.error:
            raise InvalidParameter(
                f"accuracy: found an error of {demand.error:.2g} left for modes of edges {self.boundary}, "
                f"expected at least {error:.2g}, the error of their polynomials; loosen the accuracy, shorten "
                "reversal_s, or remove 'edges'"
            )

        # modes are solved in a block per pair of parities: an axis with equal edges has two
        p_x, p_y = degrees_called_for(demand.surface.plate, demand.once(cut_of).static_to_hz)
        n_blocks: int = 2 ** sum(self.boundary[at] == self.boundary[at + 2] for at in (0, 1))
        return Size(error=error, n_operations=OF_MODES * (pi / 4 * p_x * p_y) ** 2 / n_blocks)

    def in_setup(self) -> dict[str, str]:
        return {"boundary": self.boundary}

    def in_plate(self, scene: Surroundings) -> PlateContent:
        return PlateContent(most_ritz_modes=MOST_RITZ_MODES)

    @property
    def singular(self) -> bool:
        """True if a free edge meets a clamped one."""
        return any(
            {a, b} == {"C", "F"} for a, b in zip(self.boundary, self.boundary[1:] + self.boundary[0], strict=True)
        )

    def error(self, scene: Surroundings) -> float:
        """Return the error of the polynomials in frequency and visible phase."""
        from ...time_reversal.plate.plate import degrees

        surface = scene.surface
        degree = min(degrees(surface.plate, surface.f_max_hz))
        missed = (OF_SINGULAR_CORNER if self.singular else OF_OTHER_CORNERS) / degree**4
        return float(missed * (3 + SEEN * 2 * pi * surface.f_max_hz * surface.reversal_s))
