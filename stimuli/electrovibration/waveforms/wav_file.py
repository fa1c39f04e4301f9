"""A voltage from a WAV file."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np

from tactometry.arguments import require
from tactometry.errors import InvalidParameter, count_of
from tactometry.files.durable import read_file
from tactometry.files.samples import Wav, wav_of
from tactometry.provenance import sha256
from tactometry.signal import Signal

from ...arrays import FloatArray
from .waveform import check_timing, peak_voltage_v, ramped

FileLevelUnit = Literal["dB re 1 V", "V", "dB re file"]
LARGEST_WAV: Final = 2**28
CLIPPED_RUN: Final = 3
"""So many neighbouring samples at full scale were cut off (unverified default)."""
_LARGEST: Final = {"u1": 127 / 128, "i2": 1 - 2.0**-15, "i4": 1 - 2.0**-23, "f4": 1.0, "f8": 1.0}
"""The largest sample of each form, as a part of full scale; 24 bits are read as the upper ones of 32."""


@dataclass(frozen=True)
class WavFile:
    """The samples of a WAV file of one channel, scaled to a level.

    Raises `InvalidFile` if the file cannot be read; `InvalidParameter` if a value is outside of its domain, or the file
    has another digest, rate or length, several channels, no samples but 0, one that is not finite, or samples that were
    cut off at full scale.

    Parameters
    ----------
    path : str
        The file: whole numbers of 8 to 32 bits, or floating point; its path is relative to the study file.
    sha256 : str
        Digest that detects changes to the file. Without it the file is refused, and the error states the digest
        to write.
    rate_hz : float
        Sampling rate of the file, stated so that data can be read without it.
    duration_s : float
        Duration of the file, stated so that data can be read without it.
    level_unit : {"dB re 1 V", "V", "dB re file"}
        What `at` takes: the peak of the largest sample, decibel re 1 V or volt, or decibel re what is in the file.
    volts_per_unit : float, optional
        What a sample of 1 stands for, V at the load, where the level is re the file: 1 for a file in volts.
    ramp_s : float
        Raised-cosine ramp on and off; none by default.
    read : bool
        Whether the file is read now; without it nothing can be played.
    """

    path: str
    rate_hz: float
    duration_s: float
    sha256: str = ""
    level_unit: FileLevelUnit = "dB re 1 V"
    volts_per_unit: float | None = None
    ramp_s: float = 0.0
    read: bool = True

    def __post_init__(self) -> None:
        require.one_of("WavFile.level_unit", self.level_unit, get_args(FileLevelUnit))
        check_timing("WavFile", self.duration_s, self.ramp_s, self.rate_hz)
        is_scaled = self.volts_per_unit is not None
        needed = "a number beside level_unit = 'dB re file', and there alone"
        found = "none" if self.volts_per_unit is None else f"{self.volts_per_unit:g} V"
        require.expect(is_scaled == (self.level_unit == "dB re file"), "WavFile.volts_per_unit", found, needed)
        if self.volts_per_unit is not None:
            require.positive("WavFile", volts_per_unit=self.volts_per_unit)
        if self.read:
            _ = self._samples

    def at(self, level: float) -> Signal:
        """(1, n_samples) volt.

        Raises `InvalidParameter` if the level is none, or the file was not read.
        """
        if self.level_unit == "dB re file":
            volts = (self.volts_per_unit or 0.0) * peak_voltage_v(level)
        else:
            volts = peak_voltage_v(level, self.level_unit) / float(np.abs(self._samples).max())
        samples = ramped(volts * self._samples, self.ramp_s, self.rate_hz)
        return Signal(samples[None, :], self.rate_hz, "V")

    @cached_property
    def _samples(self) -> FloatArray:
        """(n_samples,) parts of full scale."""
        content = read_file(Path(self.path), "a WAV file", LARGEST_WAV)
        digest = sha256(content)
        is_this = f"{digest!r}, which is that of {self.path}; write it, if this is the file that is meant"
        require.expect(self.sha256 == digest, "WavFile.sha256", repr(self.sha256), is_this)
        try:
            wav = wav_of(content)
            samples = _one_channel(wav)
        except ValueError as damage:
            raise InvalidParameter(f"WavFile.path: {self.path}: {damage}") from None
        rate_hz = wav.rate_hz
        resample = f"{self.rate_hz:g} Hz, as stated; state that of the file, or resample it to that of the output"
        require.expect(rate_hz == self.rate_hz, "WavFile.rate_hz", f"a file at {rate_hz:g} Hz", resample)
        length_s = len(samples) / rate_hz
        is_as_long = abs(length_s - self.duration_s) < 1 / rate_hz
        require.expect(is_as_long, "WavFile.duration_s", f"{self.duration_s:g} s", f"{length_s:g} s, that of the file")
        return samples


def _one_channel(wav: Wav) -> FloatArray:
    """Return the samples of a one-channel file as parts of full scale.

    Raises `ValueError` if it has several channels, or samples that are not finite, are all 0 or are cut off at full
    scale.
    """
    n_channels = wav.frames.shape[1]
    if n_channels != 1:
        raise ValueError(f"found {n_channels} channels, expected one; keep the one that is meant")
    form = wav.frames.dtype.str[1:]
    if form not in _LARGEST:
        raise ValueError(f"found samples of form {form}, expected whole numbers of 8 to 32 bits, or floating point")
    samples = wav.parts()[:, 0]
    _refuse_unsound(samples, _LARGEST[form], floating=form[0] == "f")
    return samples


def _refuse_unsound(samples: FloatArray, largest: float, *, floating: bool) -> None:
    if samples.size < 2:
        raise ValueError(f"found {count_of(samples.size, 'sample')}, expected at least two")
    if not np.isfinite(samples).all():
        place = int(np.argmin(np.isfinite(samples)))
        raise ValueError(f"found {samples[place]} as sample {place}, expected finite numbers alone")
    peak = float(np.abs(samples).max())
    if peak == 0:
        raise ValueError("found silence alone, expected a sample that is not 0")
    at_end = np.abs(samples) == largest if floating else np.abs(samples) >= largest
    run = np.convolve(at_end, np.ones(CLIPPED_RUN), "valid") == CLIPPED_RUN
    if run.any():
        place = int(np.argmax(run))
        raise ValueError(
            f"found {CLIPPED_RUN} neighbouring samples at full scale, from {place} on, expected none: it is clipped; "
            "write it with a smaller peak"
        )
