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
"""Number of neighbouring samples at full scale that count as clipped (unverified default)."""
_LARGEST: Final = {"u1": 127 / 128, "i2": 1 - 2.0**-15, "i4": 1 - 2.0**-23, "f4": 1.0, "f8": 1.0}
"""Largest sample of each format; 24-bit samples are read into the upper bits of 32."""


@dataclass(frozen=True)
class WavFile:
    """The samples of a WAV file of one channel, scaled to a level.

    Raises `InvalidFile` if the file cannot be read; `InvalidParameter` if a value is outside of its domain, or the file
    differs in digest, rate or length, has several channels, is silent, is clipped or contains a sample that is not
    finite.

    Parameters
    ----------
    path : str
        Path of the file, relative to the study file: integers of 8 to 32 bits, or floating point.
    sha256 : str
        Digest that detects changes to the file. Without it the file is refused, and the error states the digest
        to write.
    rate_hz : float
        Sampling rate of the file, stated so that data can be read without the file.
    duration_s : float
        Duration of the file, stated so that data can be read without the file.
    level_unit : {"dB re 1 V", "V", "dB re file"}
        Unit of the level: the peak voltage in decibel re 1 V or in volt, or decibel relative to the file.
    volts_per_unit : float, optional
        Voltage at the load for a sample of 1, if the level is relative to the file: 1 for a file in volts.
    ramp_s : float
        Length of the raised-cosine ramps at onset and offset; none by default.
    read : bool
        Whether to read the file now; an unread file cannot be played.
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
        needed = "a number if level_unit = 'dB re file', else none"
        found = "none" if self.volts_per_unit is None else f"{self.volts_per_unit:g} V"
        require.expect(is_scaled == (self.level_unit == "dB re file"), "WavFile.volts_per_unit", found, needed)
        if self.volts_per_unit is not None:
            require.positive("WavFile", volts_per_unit=self.volts_per_unit)
        if self.read:
            _ = self._samples

    def at(self, level: float) -> Signal:
        """Return the samples (1, n_samples) in volt.

        Raises `InvalidParameter` if the level is invalid or the file was not read.
        """
        if self.level_unit == "dB re file":
            volts = (self.volts_per_unit or 0.0) * peak_voltage_v(level)
        else:
            volts = peak_voltage_v(level, self.level_unit) / float(np.abs(self._samples).max())
        samples = ramped(volts * self._samples, self.ramp_s, self.rate_hz)
        return Signal(samples[None, :], self.rate_hz, "V")

    @cached_property
    def _samples(self) -> FloatArray:
        """Return the samples (n_samples,) as parts of full scale."""
        content = read_file(Path(self.path), "a WAV file", LARGEST_WAV)
        digest = sha256(content)
        is_this = f"{digest!r}, the digest of {self.path}; enter it if this is the intended file"
        require.expect(self.sha256 == digest, "WavFile.sha256", repr(self.sha256), is_this)
        try:
            wav = wav_of(content)
            samples = _one_channel(wav)
        except ValueError as damage:
            raise InvalidParameter(f"WavFile.path: {self.path}: {damage}") from None
        rate_hz = wav.rate_hz
        resample = f"{self.rate_hz:g} Hz, as stated; state the file's rate, or resample it to the output's rate"
        require.expect(rate_hz == self.rate_hz, "WavFile.rate_hz", f"a file at {rate_hz:g} Hz", resample)
        length_s = len(samples) / rate_hz
        is_as_long = abs(length_s - self.duration_s) < 1 / rate_hz
        require.expect(is_as_long, "WavFile.duration_s", f"{self.duration_s:g} s", f"{length_s:g} s, the file's length")
        return samples


def _one_channel(wav: Wav) -> FloatArray:
    """Return the samples of a one-channel file as parts of full scale.

    Raises `ValueError` if it has several channels, or samples that are not finite, all 0 or clipped.
    """
    n_channels = wav.frames.shape[1]
    if n_channels != 1:
        raise ValueError(f"found {n_channels} channels, expected one; keep the intended channel")
    form = wav.frames.dtype.str[1:]
    if form not in _LARGEST:
        raise ValueError(f"found samples of format {form}, expected whole numbers of 8 to 32 bits, or floating point")
    samples = wav.parts()[:, 0]
    _refuse_unsound(samples, _LARGEST[form], floating=form[0] == "f")
    return samples


def _refuse_unsound(samples: FloatArray, largest: float, *, floating: bool) -> None:
    if samples.size < 2:
        raise ValueError(f"found {count_of(samples.size, 'sample')}, expected at least two")
    if not np.isfinite(samples).all():
        place = int(np.argmin(np.isfinite(samples)))
        raise ValueError(f"found {samples[place]} as sample {place}, expected finite numbers only")
    peak = float(np.abs(samples).max())
    if peak == 0:
        raise ValueError("found only zeros, expected a sample that is not 0")
    at_end = np.abs(samples) == largest if floating else np.abs(samples) >= largest
    run = np.convolve(at_end, np.ones(CLIPPED_RUN), "valid") == CLIPPED_RUN
    if run.any():
        place = int(np.argmax(run))
        raise ValueError(
            f"found {CLIPPED_RUN} neighbouring samples at full scale, from {place} on, expected none: it is clipped; "
            "write it with a smaller peak"
        )
