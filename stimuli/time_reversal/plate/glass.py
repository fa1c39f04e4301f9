"""Glasses for screens: elastic constants with their source."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tactometry.arguments.checked import checked
from tactometry.arguments.require import one_of
from tactometry.config.quantity import as_si
from tactometry.config.strict import build
from tactometry.config.toml import errors_in, read_table

from .plate import Plate


@checked
@dataclass(frozen=True)
class Glass:
    """Young's modulus (Pa), Poisson's ratio, density (kg/m^3) and their source."""

    name: str
    youngs_modulus_pa: float
    poisson_ratio: float
    density_kg_per_m3: float
    source: str

    def plate(self, length_m: float, width_m: float, thickness_m: float, boundary: str) -> Plate:
        """Return a plate of this glass.

        >>> round(BOROFLOAT_33.plate(0.297, 0.210, 1.1e-3, "SSSS").mass_kg, 4)
        0.153
        """
        return Plate(
            length_m, width_m, thickness_m, self.youngs_modulus_pa, self.poisson_ratio, self.density_kg_per_m3, boundary
        )


BOROFLOAT_33 = Glass("Borofloat 33", 64e9, 0.20, 2230.0, "SCHOTT, mechanical properties of BOROFLOAT 33")
DURAN = Glass("DURAN borosilicate 3.3", 63e9, 0.20, 2230.0, "DURAN data sheet")
SODA_LIME = Glass("soda-lime", 72.8e9, 0.222, 2563.0, "Sci. Rep. 2021, s41598-021-04045-6, table 1")
GORILLA_4 = Glass("Gorilla 4", 66e9, 0.22, 2420.0, "density: release of Gorilla Glass 4; moduli: unverified default")
D263T = Glass("D263T", 72.9e9, 0.208, 2510.0, "unverified default")

GLASSES = {glass.name: glass for glass in (BOROFLOAT_33, DURAN, SODA_LIME, GORILLA_4, D263T)}

A4_SCREEN = BOROFLOAT_33.plate(0.297, 0.210, 1.1e-3, "SSSS")
"""The thesis's prototype: A4, 1.1 mm. The glass and the edges are assumptions."""


FREQUENCY_SHIFT_PER_K: Final = -5e-5
"""Relative shift of the modal frequencies of borosilicate glass per kelvin; unverified default."""

MOST_SHIFT: Final = 0.1
"""Largest relative shift of the frequencies for which a proportional law is used."""

MATERIAL: Final = ("youngs_modulus_pa", "poisson_ratio", "density_kg_per_m3")


@dataclass(frozen=True)
class NamedGlass:
    """A glass by its name, which replaces the material keys.

    Parameters
    ----------
    glass : str
        Name of the glass, one of `GLASSES`.

    >>> NamedGlass("DURAN borosilicate 3.3").material["density_kg_per_m3"]
    2230.0
    """

    glass: str

    def __post_init__(self) -> None:
        one_of("NamedGlass.glass", self.glass, GLASSES)

    @property
    def material(self) -> dict[str, float]:
        return {key: getattr(GLASSES[self.glass], key) for key in MATERIAL}


@checked
def read_plate(path: str | Path) -> Plate:
    """Read the plate of a file.

    Such a file is::

        glass = "Borofloat 33"
        length_m = 0.297
        width_m = "210 mm"
        thickness_m = 1.1e-3
        boundary = "FFFF"

    Raises `InvalidFile` if the file cannot be read, a key is unknown or missing, or a value is out of range.
    """
    path = Path(path)
    table = read_table(path, "a plate")
    with errors_in(path):
        named = {"glass": table.pop("glass")} if "glass" in table else None
        material = {} if named is None else build(NamedGlass, named, "").material
        return build(Plate, as_si({**material, **table}, ""), "plate")
