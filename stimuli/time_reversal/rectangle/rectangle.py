"""A rectangle with edges: what its modes depend on, as wavenumbers, before any material gives them a frequency."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Rectangle:
    """0..length in x and 0..width in y.

    Parameters
    ----------
    length_m, width_m : float
        Above 0.
    boundary : str
        Four letters, S (simply supported), C (clamped) or F (free), for x = 0, y = 0, x = length, y = width.
    poisson_ratio : float
        The one constant of a material that enters a shape, through free edges.
    """

    length_m: float
    width_m: float
    boundary: str
    poisson_ratio: float

    @property
    def edges_x(self) -> str:
        """The edges that the functions of x meet: at x = 0 and at x = length."""
        return self.boundary[::2]

    @property
    def edges_y(self) -> str:
        return self.boundary[1::2]

    @property
    def n_rigid(self) -> int:
        """Number of rigid-body motions, {1, x, y} under the essential conditions of the four edges.

        >>> [Rectangle(0.3, 0.2, boundary, 0.3).n_rigid for boundary in ("FFFF", "SFFF", "SFSF", "CFFF")]
        [3, 1, 0, 0]
        """
        edges = (self.edges_x, self.edges_y)
        constant = [pair == "FF" for pair in edges]
        linear = ["C" not in pair and pair.count("S") <= 1 for pair in edges]
        return constant[0] * constant[1] + linear[0] * constant[1] + constant[0] * linear[1]
