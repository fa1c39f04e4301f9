"""Bench files: the screen, the output and the limits of one bench, strictly read."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from tactometry.errors import InvalidFile, InvalidParameter, TactometryError, nearest
from tactometry.limits import Limits
from tactometry.quantity import as_si
from tactometry.strict import build

OUTPUTS = ("null",)


@dataclass(frozen=True)
class Screen:
    """The participant's screen: full screen, or a window of `width_px` x `height_px` pixels; `height_m` as measured."""

    fullscreen: bool = True
    width_px: int = 1280
    height_px: int = 800
    height_m: float | None = None
    language: str = "en"

    def __post_init__(self) -> None:
        for name in ("width_px", "height_px"):
            if getattr(self, name) < 320:
                raise InvalidParameter(f"Screen.{name}: found {getattr(self, name)}, expected at least 320 pixels")
        if self.height_m is not None and not 0 < self.height_m < 10:
            raise InvalidParameter(f"Screen.height_m: found {self.height_m:g}, expected above 0 and below 10 m")


@dataclass(frozen=True)
class OutputTable:
    """The output by kind; `null` renders and checks every signal and emits none."""

    kind: str = "null"

    def __post_init__(self) -> None:
        if self.kind not in OUTPUTS:
            raise InvalidParameter(
                f"OutputTable.kind: found {self.kind!r}, expected one of {', '.join(OUTPUTS)}"
                f"{nearest(self.kind, OUTPUTS)}"
            )


@dataclass(frozen=True)
class BenchFile:
    """One bench. Its limits stand beside those of the study: the tighter one holds."""

    screen: Screen = field(default_factory=Screen)
    output: OutputTable = field(default_factory=OutputTable)
    limits: Limits | None = None

    def limits_with(self, study: Limits) -> Limits:
        """The tighter of both limits."""
        if self.limits is None:
            return study
        return Limits(
            min(study.voltage_peak_v, self.limits.voltage_peak_v),
            min(study.duration_s, self.limits.duration_s),
        )


def load_bench(path: Path | None) -> BenchFile:
    """A bench file, or the default bench without one.

    Raises
    ------
    InvalidFile
        If the file cannot be read, or holds anything unknown or impossible.
    """
    if path is None:
        return BenchFile()
    try:
        return build(BenchFile, as_si(tomllib.loads(path.read_text("utf-8")), ""), "")
    except OSError as error:
        raise InvalidFile(f"{path}: cannot read the bench file ({error.strerror}), expected a readable file") from None
    except TactometryError as error:
        raise InvalidFile(f"{path}, {error}") from None
    except (ValueError, RecursionError) as error:
        raise InvalidFile(f"{path}: found no valid TOML ({error}), expected a bench file") from None
