"""A plate from a TOML file: the fields of `Plate`, or a glass by name and its sizes."""

from pathlib import Path
from typing import Final

from tactometry.arguments.checked import checked
from tactometry.config.quantity import as_si
from tactometry.config.strict import build
from tactometry.config.toml import located, read_table
from tactometry.errors import InvalidParameter, nearest

from .glass import GLASSES
from .plate import Plate

MATERIAL: Final = ("youngs_modulus_pa", "poisson_ratio", "density_kg_per_m3")


@checked
def read_plate(path: Path) -> Plate:
    """The plate of a file such as::

        glass = "Borofloat 33"
        length_m = 0.297
        width_m = "210 mm"
        thickness_m = 1.1e-3
        boundary = "FFFF"

    Raises
    ------
    InvalidFile
        If the file cannot be read, a key is unknown or missing, or a value is out of range.
    """
    table = read_table(path, "a plate")
    with located(path):
        return build(Plate, as_si({**_glass(table.pop("glass", None)), **table}, ""), "plate")


def _glass(name: object) -> dict[str, object]:
    if name is None:
        return {}
    if not isinstance(name, str) or name not in GLASSES:
        hint = nearest(name, GLASSES) if isinstance(name, str) else ""
        raise InvalidParameter(f"glass: found {name!r}, expected one of {', '.join(GLASSES)}{hint}")
    return {key: getattr(GLASSES[name], key) for key in MATERIAL}
