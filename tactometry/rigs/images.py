"""Images on the pages of text, from files whose digests a study states."""

import io
from dataclasses import dataclass
from pathlib import Path

from ..arguments.require import expect
from ..errors import rewording
from ..files.durable import read_file
from ..provenance import sha256

LARGEST_IMAGE = 50_000_000
"""Bytes of a file."""


@dataclass(frozen=True)
class ImageTable:
    """An image of a page: its `path`, relative to the study file, and the `sha256` of the file.

    Parameters
    ----------
    path : str
        A PNG or JPEG file, relative to the study file.
    sha256 : str
        Of the file; a refusal tells it.
    """

    path: str
    sha256: str = ""


@dataclass(frozen=True)
class PageImage:
    """A file that can be drawn, and its width over its height."""

    path: str
    ratio: float


def image_of(table: ImageTable, where: str) -> PageImage:
    """The image of a table, looked at.

    Raises `InvalidParameter` if the file cannot be read, is another than the study states, or no image.
    """
    from PIL import Image as Pillow, UnidentifiedImageError

    path = Path(table.path)
    with rewording(lambda words: f"{where}.path: {words}; it is relative to the study file"):
        content = read_file(path, "an image", LARGEST_IMAGE)
    digest = sha256(content)
    is_this = f"that of {path}, {digest!r}; state it, so that another file is not shown in its place"
    expect(table.sha256 == digest, f"{where}.sha256", repr(table.sha256) if table.sha256 else "no such key", is_this)
    try:
        width, height = Pillow.open(io.BytesIO(content)).size
    except (UnidentifiedImageError, OSError, Pillow.DecompressionBombError):
        width = height = 0
    expect(width > 0, f"{where}.path", f"{table.path!r}, which is no image", "a PNG or a JPEG")
    return PageImage(str(path.resolve()), width / height)
