"""Stimuli of a study, adapted to the output of a bench."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tactometry.arguments.require import expect
from tactometry.devices.outputs.output import expect_following
from tactometry.errors import InvalidParameter, rewording
from tactometry.position_dependent import FollowsFinger
from tactometry.rigs.emitter import NO_POSITION, render
from tactometry.signal import Signal, Stimulus

from ..study.experiment import Experiment
from .bench_file import BenchFile, Devices
from .bench_parts import Learnt, OutputPart


@dataclass(frozen=True)
class OnChannels:
    """Stimulus on some of `n_channels` channels. The others are off."""

    stimulus: Stimulus
    channels: tuple[int, ...]
    n_channels: int

    @property
    def level_unit(self) -> str:
        return self.stimulus.level_unit

    def at(self, level: float) -> Signal:
        """Return the signal at a level, on the output's channels.

        A signal with another number of channels is returned unchanged, so that the output rejects it.
        """
        signal = self.stimulus.at(level)
        if signal.samples.shape[0] != len(self.channels):
            return signal
        samples = np.zeros((self.n_channels, signal.samples.shape[1]))
        samples[list(self.channels)] = signal.samples
        return Signal(samples, signal.rate_hz, signal.unit)


@dataclass(frozen=True)
class CommandedSupply:
    """Switched stimulus whose supply falls with the level, below `highest`.

    Drives are proportional to the supply. Below the lowest supply, bursts and pulses become shorter.
    """

    stimulus: Stimulus
    highest: float
    lowest_part: float

    @property
    def level_unit(self) -> str:
        return self.stimulus.level_unit

    def at(self, level: float) -> Signal:
        in_db = self.level_unit.startswith("dB")
        part = 10 ** ((level - self.highest) / 20) if in_db else level / self.highest
        part = min(max(part, self.lowest_part), 1.0)
        signal = self.stimulus.at(level - 20 * math.log10(part) if in_db else level / part)
        return Signal(part * signal.samples, signal.rate_hz, signal.unit)


@dataclass(frozen=True)
class Board:
    """Board that switches between `supply_v`, its negative and off.

    Its channels drive actuators on a plate, except the one of an `electrode`. The burst length sets the level of a
    focus, the pulse width that of an electrovibration carrier. A supply with a `lowest_supply_v` is lowered first.
    """

    supply_v: float
    rate_hz: float
    n_channels: int
    electrode: int | None
    lowest_supply_v: float | None = None

    def made(self, stimulus: Stimulus, highest: float) -> Stimulus:
        """Return a stimulus as this board switches it, up to a highest level.

        A stimulus that the board cannot switch is returned unchanged, so that the output rejects it.
        """
        switched = self._switched(stimulus)
        if switched is stimulus or self.lowest_supply_v is None:
            return switched
        return CommandedSupply(switched, highest, self.lowest_supply_v / self.supply_v)

    def _switched(self, stimulus: Stimulus) -> Stimulus:
        from tactometry.stimuli.electrovibration.waveforms.amplitude_modulated import AmplitudeModulated, of_supply
        from tactometry.stimuli.hybrid import Hybrid, MeasuredHybrid
        from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain, TimeReversalStimulus

        plates = tuple(channel for channel in range(self.n_channels) if channel != self.electrode)
        electrode = () if self.electrode is None else (self.electrode,)
        match stimulus:
            case FocusTrain() | TimeReversalStimulus():
                return self._on(plates, replace(stimulus, supply_v=self.supply_v))
            case Hybrid() | MeasuredHybrid():
                focus: Any = replace(stimulus.focus, supply_v=self.supply_v)
                return self._on((*plates, *electrode), replace(stimulus, focus=focus))
            case AmplitudeModulated():
                return self._on(electrode, of_supply(stimulus, self.rate_hz, self.supply_v))
        return stimulus

    def _on(self, channels: tuple[int, ...], stimulus: Stimulus) -> Stimulus:
        return stimulus if self.electrode is None else OnChannels(stimulus, channels, self.n_channels)


def board_of(output: OutputPart) -> Board | None:
    """Return the board of a bench, or None for another output."""
    settings, gain = output.settings, output.gain
    if not settings.connected or gain is None:
        return None
    from tactometry.devices.outputs.packed import PackedSettings

    if not isinstance(settings, PackedSettings):
        return None
    supply_v, channels = gain.load_volts_per_unit, (settings.n_channels, settings.electrode)
    return Board(supply_v, settings.rate_hz, *channels, settings.lowest_supply_v)


def bank_on(experiment: Experiment, bench: BenchFile) -> Mapping[str, Stimulus]:
    """Return the stimuli by name, as this bench plays them.

    Raises `InvalidFile` or `InvalidParameter` if learned responses cannot be read or do not suit a stimulus, or the
    board cannot switch a stimulus.
    """
    bank, board = bank_of(experiment, bench.time_reversal), board_of(bench.output)
    if board is None:
        return bank
    switched = {}
    for name, stimulus in bank.items():
        lowest, highest = experiment.bounds(name)
        with rewording(partial("output, {}: {}; nothing was played".format, name)):
            switched[name] = board.made(stimulus, highest)
            if switched[name] is not stimulus:
                switched[name].at(lowest)
    return switched


def bank_of(experiment: Experiment, learnt: Learnt | None) -> Mapping[str, Stimulus]:
    """Return the stimuli by name; those of plates use the measured impulse responses.

    Raises `InvalidFile` if the file cannot be read. Raises `InvalidParameter` if the responses do not suit a stimulus,
    or its highest level exceeds the amplifier.
    """
    if learnt is None:
        return experiment.bank
    from tactometry.stimuli import hybrid
    from tactometry.stimuli.time_reversal.responses.measured import read
    from tactometry.stimuli.time_reversal.stimulus import focus_train

    responses = read([Path(learnt.responses)])

    def adapt(stimulus: Stimulus) -> Stimulus:
        match stimulus:
            case focus_train.FocusTrain():
                return focus_train.measured(stimulus, responses)
            case hybrid.Hybrid():
                return hybrid.measured(stimulus, responses)
        return stimulus

    bank: dict[str, Stimulus] = {}
    for strongest in experiment.strongest():
        place = f"time_reversal.responses, {learnt.responses}, {strongest.name}"
        with rewording(partial("{}: {}".format, place)):
            bank[strongest.name] = adapt(strongest.stimulus)
            render(bank, strongest.name, strongest.level, limits=None)
    return bank


def learnt_facts(learnt: Learnt | None) -> dict[str, str | None]:
    """Return facts about the responses for the journal."""
    if learnt is None:
        return {}
    from tactometry.provenance import sha256
    from tactometry.stimuli.time_reversal.responses.learning import read_provenance

    path = Path(learnt.responses)
    provenance = read_provenance(path) if path.suffix == ".npz" else {}
    when = " ".join(str(provenance[key]) for key in ("measured_on", "measured_by") if key in provenance)
    digest = sha256(path.read_bytes())
    return {"responses": path.name, "responses_sha256": digest, "responses_measured": when or None}


def check_followed(experiment: Experiment, bench: BenchFile, devices: Devices) -> None:
    """Reject a texture that the position sensor or output cannot follow.

    Raises `InvalidParameter` if there is no position sensor, or it is a recording, or too slow for the texture at the
    speed of the touch. Raises `DeviceFailed` if the output accepts no signal that follows a finger.
    """
    driver = devices.output.driver
    for cell in experiment.cells.values() if driver.emits else ():
        stimulus = cell.stimulus  # a bench never changes a stimulus that follows a finger
        if not isinstance(stimulus, FollowsFinger):
            continue
        if devices.position is None or bench.position is None:
            raise InvalidParameter(NO_POSITION)
        recording = f"{bench.position.sensor!r}, a recording, which cannot detect a finger"
        is_live = bench.sensors[bench.position.sensor].settings.live or not driver.connected
        expect(is_live, "position.sensor", recording, "a live sensor; nothing was played")
        expect_following(driver)
        sensor = f"sensors.{bench.position.sensor}"
        with rewording(lambda words, sensor=sensor: words.replace("sensor", sensor, 1)):  # type: ignore[misc]
            stimulus.check_motion(cell.condition.speed_m_per_s or 0.0, devices.position.reader.source.rate_hz)
