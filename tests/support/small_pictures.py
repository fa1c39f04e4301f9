"""Pictures of the docs, as few bytes as they can be looked at with."""

from io import BytesIO

from PIL import Image

N_COLOURS = (256, 128, 64)
MOST_BYTES = 150_000


def small(png: bytes, width: int) -> bytes:
    """Encode a PNG of limited width with few colours, fewer if large."""
    opaque = _opaque(png, width)
    tried = [_encoded(opaque, n_colours) for n_colours in N_COLOURS]
    return next((kept for kept in tried if len(kept) <= MOST_BYTES), tried[-1])


def _opaque(png: bytes, width: int) -> Image.Image:
    with Image.open(BytesIO(png)) as picture:
        opaque = Image.alpha_composite(Image.new("RGBA", picture.size, "white"), picture.convert("RGBA")).convert("RGB")
    opaque.thumbnail((width, 10 * width), Image.Resampling.LANCZOS)
    return opaque


def _encoded(opaque: Image.Image, n_colours: int) -> bytes:
    kept = BytesIO()
    few = opaque.quantize(n_colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(kept, "PNG", optimize=True)
    return kept.getvalue()
