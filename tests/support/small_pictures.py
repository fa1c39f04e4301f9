"""Pictures of the docs, as few bytes as they can be looked at with."""

from io import BytesIO

from PIL import Image

N_COLOURS = 256


def small(png: bytes, width: int) -> bytes:
    """A PNG at most so many pixels wide, of a few colours that are near to all of its own."""
    with Image.open(BytesIO(png)) as picture:
        opaque = Image.alpha_composite(Image.new("RGBA", picture.size, "white"), picture.convert("RGBA")).convert("RGB")
        opaque.thumbnail((width, 10 * width), Image.Resampling.LANCZOS)
        kept = BytesIO()
        opaque.quantize(N_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
            kept, "PNG", optimize=True
        )
    return kept.getvalue()
