"""Registry of the textures that a study can name, by kind."""

from collections.abc import Mapping
from typing import Final

from ..waveforms.kinds import WaveformKind as TextureKind

_HERE: Final = f"{__package__}.texture"

TEXTURES: Final[Mapping[str, TextureKind]] = {
    "grating": TextureKind(f"{_HERE}:Grating", {"period_m": 2e-3}),
    "edge": TextureKind(f"{_HERE}:Region", {"left_m": 0.01, "right_m": 0.03}),
    "bump": TextureKind(f"{_HERE}:Bump", {"centre_m": 0.02, "width_m": 5e-3}),
    "velvet": TextureKind(f"{_HERE}:Velvet", {}),
    "image": TextureKind(f"{__package__}.maps:GreyImage", {"pixel_m": 1e-3, "values": [0.0, 1.0, 0.2]}),
    "height_map": TextureKind(f"{__package__}.maps:HeightMap", {"pixel_m": 1e-3, "values": [0.0, 1.0, 0.0]}),
}
