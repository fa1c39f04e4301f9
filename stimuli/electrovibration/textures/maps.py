"""Textures of a study file: picture rows, and heights along a line."""

import io
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from tactometry.arguments import require
from tactometry.arguments.checked import Positive, checked
from tactometry.errors import InvalidParameter
from tactometry.files.durable import read_file
from tactometry.files.samples import table_of_numbers
from tactometry.provenance import sha256

from ...arrays import FloatArray
from .texture import SIGNS

LARGEST_MAP: Final = 2**26


@checked
@dataclass(frozen=True)
class Mapped:
    """Values along a line or in rows, stated here or read from a file.

    `sha256` detects changes to the file.

    Raises `InvalidParameter` if there are neither or both, the digest is missing or differs, or the file contains no
    numbers, and `InvalidFile` if it cannot be read.

    Parameters
    ----------
    pixel_m : float
        Distance between neighbouring values.
    values : tuple of float
        The values themselves.
    path : str or None
        Path of a CSV file of numbers or a PNG picture (converted to grey), relative to the study file.
    sha256 : str or None
        SHA-256 digest of the file, since its numbers are part of the study.
    row : int
        The row of the file that the finger follows, from 0.
    """

    pixel_m: Positive
    values: tuple[float, ...] = ()
    path: str | None = None
    sha256: str | None = None
    row: int = 0
    _line: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        owner = type(self).__name__
        found = "both or neither of values and path"
        require.expect(bool(self.values) != (self.path is not None), owner, found, "exactly one")
        rows = self._read(owner, self.path) if self.path is not None else np.array([self.values])
        require.expect(0 <= self.row < len(rows), f"{owner}.row", self.row, "the number of an existing row, from 0")
        line = require.finite_array(f"{owner}.values", rows[self.row])
        require.expect(line.size >= 2, f"{owner}.values", f"{line.size} values", "at least two")
        object.__setattr__(self, "_line", line)

    def _read(self, owner: str, path: str) -> FloatArray:
        content = read_file(Path(path), "a picture, or numbers as CSV", LARGEST_MAP)
        digest = sha256(content)
        is_this = f"{digest!r}, the digest of {path}; enter it if this is the intended file"
        require.expect(self.sha256 == digest, f"{owner}.sha256", repr(self.sha256), is_this)
        try:
            if Path(path).suffix.lower() == ".csv":
                return table_of_numbers(io.StringIO(content.decode("utf-8")))
            return _grey_of_picture(content)
        except (ValueError, OSError) as error:
            raise InvalidParameter(f"{owner}.path: {path} cannot be read ({error}), expected CSV or PNG") from None


def _grey_of_picture(content: bytes) -> FloatArray:
    from PIL import Image as Picture, UnidentifiedImageError  # slow import

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Picture.DecompressionBombWarning)
            with Picture.open(io.BytesIO(content)) as picture:
                return np.asarray(picture.convert("L"), dtype=np.float64) / 255
    except UnidentifiedImageError:
        raise ValueError("found no picture") from None
    except SyntaxError as error:  # an invalid part of a PNG file
        raise ValueError(str(error)) from None
    except (Picture.DecompressionBombWarning, Picture.DecompressionBombError):
        raise ValueError(f"found more than {Picture.MAX_IMAGE_PIXELS} pixels") from None


@checked
@dataclass(frozen=True)
class GreyImage(Mapped):
    """A row of grey levels from 0 (black, no friction) to 1, interpolated linearly.

    Parameters
    ----------
    pixel_m : float
        Length of a pixel along the path of the finger.
    values : tuple of float
        The grey levels, from 0 (no friction) to 1; or a file, by `path`.
    path : str, optional
        A PNG or CSV file, relative to the study file.
    sha256 : str, optional
        Digest of the file; the error for a missing digest states it.
    row : int
        The row of the file that the finger follows, from 0.

    >>> GreyImage(pixel_m=1e-3, values=(0.0, 1.0, 0.2)).force_share([0.5e-3, 1e-3, 9.0]).tolist()
    [0.0, 0.5, 0.2]
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        shares = bool(((self._line >= 0) & (self._line <= 1)).all())
        extremes = f"values from {self._line.min():g} to {self._line.max():g}"
        require.expect(shares, "GreyImage.values", extremes, "numbers from 0 to 1")

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        """Return the share (0..1) of the full force at `x_m` (m), in its shape."""
        at = np.asarray(x_m, dtype=np.float64) / self.pixel_m - 0.5
        return np.asarray(np.interp(at, np.arange(self._line.size), self._line))


@checked
@dataclass(frozen=True)
class HeightMap(Mapped):
    """Heights (in any unit) rendered by their slope like a `Bump`: ``1/2 + h'(x)/(2 max |h'|)``, 1/2 outside.

    Heights are interpolated linearly. A finger that moves back feels the opposite slope. The slope rule and its scale
    are unverified defaults.

    Parameters
    ----------
    pixel_m : float
        Length of a pixel along the path of the finger.
    values : tuple of float
        The heights, in any unit; or a file, by `path`.
    path : str, optional
        A PNG or CSV file, relative to the study file.
    sha256 : str, optional
        Digest of the file; the error for a missing digest states it.
    row : int
        The row of the file that the finger follows, from 0.
    direction : int
        1 for a finger that moves along the path, -1 for one that moves back.

    >>> HeightMap(pixel_m=1.0, values=(0.0, 2.0, 2.0, 1.0)).force_share([-1.0, 0.5, 1.5, 2.5]).tolist()
    [0.5, 1.0, 0.5, 0.25]
    """

    direction: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        require.one_of("HeightMap.direction", self.direction, SIGNS)
        uneven = bool(np.diff(self._line).any())
        require.expect(uneven, "HeightMap.values", "equal heights", "some that differ")

    def force_share(self, x_m: ArrayLike) -> FloatArray:
        """Return the share (0..1) of the full force at `x_m` (m), in its shape."""
        steps = np.diff(self._line)
        at = np.floor(np.asarray(x_m, dtype=np.float64) / self.pixel_m).astype(int)
        slopes = np.where((at >= 0) & (at < steps.size), steps[np.clip(at, 0, steps.size - 1)], 0.0)
        return np.asarray(0.5 + self.direction * slopes / (2 * np.abs(steps).max()))
