"""The wave that focuses, as a film."""

import shutil
from functools import cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import animation, colormaps, rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from tactometry.arguments.require import expect
from tactometry.errors import InvalidParameter

from ..plan import Result
from .courses import DIVERGING, draw_map

FORMATS = (".gif", ".mp4")
FRAMES_PER_S = 20
SIZE_IN = (6.4, 4.6)
RESOLUTION_DPI = 100
GREYS = 31
"""For words and lines."""


class MapWriter(animation.AbstractMovieWriter):
    """A GIF whose colours are those of a map, and greys: an own choice for each frame takes white ones, and is slow."""

    def setup(self, fig: Figure, outfile: Any, dpi: float | None = None) -> None:
        super().setup(fig, outfile, dpi)
        self._pictures: list[Image.Image] = []

    def grab_frame(self, **options: Any) -> None:
        drawn = BytesIO()
        self.fig.savefig(drawn, format="rgba", dpi=self.dpi, **options)
        picture = Image.frombytes("RGBA", self.frame_size, drawn.getvalue()).convert("RGB")
        self._pictures.append(picture.quantize(palette=_palette(), dither=Image.Dither.NONE))

    def finish(self) -> None:
        first, *others = self._pictures
        first.save(self.outfile, save_all=True, append_images=others, duration=round(1e3 / self.fps), loop=0)


@cache
def _palette() -> Image.Image:
    """255 colours are what a GIF has, beside one for what does not change."""
    of_map = colormaps[DIVERGING](np.linspace(0, 1, 255 - GREYS))[:, :3]
    greys = np.repeat(np.linspace(0, 1, GREYS), 3).reshape(GREYS, 3)
    image = Image.new("P", (1, 1))
    image.putpalette(np.rint(255 * np.concatenate([of_map, greys])).astype(np.uint8).tobytes())
    return image


def write_film(result: Result, title: str, path: Path) -> None:
    """Write the frames of ``movie_m`` as GIF or MP4.

    Raises `InvalidParameter` if the suffix is another, or an MP4 is asked for without ffmpeg.
    """
    writer = _writer(path)
    values = result.values
    frames, times_s = values["movie_m"], values["frames_s"]
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    image = draw_map(axes, values["x_m"], values["y_m"], frames[0], float(np.abs(frames).max()) / 2)
    figure.colorbar(image, ax=axes, label="displacement (µm), cut at half of the peak", shrink=0.8)
    figure.suptitle(title, fontsize="medium")
    with rc_context({"animation.ffmpeg_path": _ffmpeg()}), writer.saving(figure, str(path), RESOLUTION_DPI):
        for time_s, frame in zip(times_s, frames, strict=True):
            image.set_data(frame.T * 1e6)
            axes.set_title(f"{time_s * 1e6:+.0f} µs from the focus", fontsize="small")
            writer.grab_frame()
            figure.set_layout_engine("none")  # all frames are laid out as the first


def _writer(path: Path) -> Any:
    expect(path.suffix in FORMATS, "--movie", repr(str(path)), f"a name that ends in {' or '.join(FORMATS)}")
    if path.suffix == ".gif":
        return MapWriter(fps=FRAMES_PER_S)
    if not _ffmpeg():
        raise InvalidParameter(
            "--movie: found no ffmpeg, which writes MP4, expected it; install it or the package imageio-ffmpeg (the "
            "extra film), or write a .gif"
        )
    return animation.FFMpegWriter(fps=FRAMES_PER_S)


def _ffmpeg() -> str:
    """The program on the path, or that of the package imageio-ffmpeg; empty without."""
    program = shutil.which("ffmpeg")
    if program or not find_spec("imageio_ffmpeg"):
        return program or ""
    from imageio_ffmpeg import get_ffmpeg_exe

    return str(get_ffmpeg_exe())
