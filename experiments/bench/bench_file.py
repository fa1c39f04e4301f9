"""Bench files: the screen, the output, the sensors and the limits of one bench, strictly read."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from datetime import date
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactometry.arguments.require import expect, finite, not_zero, one_of, some, whole
from tactometry.config.quantity import as_si
from tactometry.config.strict import as_table, build, build_kind, check_keys
from tactometry.config.toml import errors_in, read_table
from tactometry.devices.kinds import OUTPUTS, SENSORS, OutputSettings
from tactometry.devices.measured import Measured
from tactometry.devices.outputs.gain import Gain, required_gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import RAMP_S, NullSettings
from tactometry.devices.sensors.reader import Reader, SensorSettings
from tactometry.devices.sensors.streamed import ForceCalibration, StreamedSensor, streamed_force, streamed_position
from tactometry.rigs.texts import languages
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.session.event import TRACE_KINDS, TraceKind
from tactometry.session.request import Fact, Facts

from ..study.study_file import no_such

if TYPE_CHECKING:
    from tactometry.rigs.window import Window

LONGEST_DELAY_S = 0.05
"""Of a sensor: half of the time after which a silent one is lost (unverified default)."""


@dataclass(frozen=True)
class DisplayTable:
    """The participant's screen: full screen, or a window of `width_px` x `height_px` pixels; `height_m` as measured;
    `screen` is its number, from 0, where several are connected.

    Before the first touch of each kind it is shown and tried without a stimulus, unless `dry_run` is false.
    """

    fullscreen: bool = True
    width_px: int = 1280
    height_px: int = 800
    height_m: float | None = None
    language: str = "en"
    dry_run: bool = True
    screen: int = 0

    def __post_init__(self) -> None:
        expect(self.width_px >= 320, "DisplayTable.width_px", self.width_px, "at least 320 pixels")
        expect(self.height_px >= 320, "DisplayTable.height_px", self.height_px, "at least 320 pixels")
        whole("DisplayTable", lowest=0, screen=self.screen)
        one_of("DisplayTable.language", self.language, languages())
        if self.height_m is not None:
            expect(0 < self.height_m < 10, "DisplayTable.height_m", f"{self.height_m:g}", "above 0 and below 10 m")

    def window(self) -> "Window":
        """The window of a participant, open.

        Raises
        ------
        InvalidParameter
            If the screen is not connected.
        DeviceFailed
            If it does not open.
        """
        from tactometry.rigs.window import Window

        return Window(fullscreen=self.fullscreen, size=(self.width_px, self.height_px), screen=self.screen)


@dataclass(frozen=True)
class OutputPart:
    """The output, what its numbers become, what it drives, and the ramps of its signals.

    `ungated` says that it may play under a finger whose force nobody measures.
    """

    settings: OutputSettings = field(default_factory=NullSettings)
    gain: Gain | None = None
    load: Load | None = None
    ramp_s: float = RAMP_S
    ungated: bool = False

    def __post_init__(self) -> None:
        if self.settings.connected:
            required_gain(self.gain, "OutputPart.gain")
        expect(0 <= self.ramp_s <= 1, "OutputPart.ramp_s", f"{self.ramp_s:g}", "from 0 to 1 s")


@dataclass(frozen=True)
class SensorPart:
    """A sensor; `delay_s` is how long its stamps are after what they tell of, as measured."""

    settings: SensorSettings
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        expected = f"from 0 to {LONGEST_DELAY_S:g} s: a stop comes so much later"
        expect(0 <= self.delay_s <= LONGEST_DELAY_S, "SensorPart.delay_s", f"{self.delay_s:g}", expected)

    def reader(self) -> Reader:
        return Reader(self.settings.source(), self.delay_s)


@dataclass(frozen=True)
class ForcePart:
    """The force: one channel (from 0) of a sensor of the file; `release` if it must leave its band between touches."""

    sensor: str
    calibration: ForceCalibration
    channel: int = 0
    release: bool = True


@dataclass(frozen=True)
class PositionPart:
    """The finger's position: one channel (from 0) of a sensor per axis, which counts `zero_counts` at position 0."""

    sensor: str
    channels: tuple[int, ...]
    metres_per_count: float
    zero_counts: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        some("PositionPart.channels", self.channels)
        n_zeros = len(self.zero_counts)
        expect(n_zeros in (0, len(self.channels)), "PositionPart.zero_counts", n_zeros, "one for each channel, or none")
        not_zero("PositionPart", metres_per_count=self.metres_per_count)
        finite("PositionPart", **{f"zero_counts[{n}]": zero for n, zero in enumerate(self.zero_counts)})


@dataclass(frozen=True)
class Learnt:
    """Impulse responses of this bench: `responses` is the file that `tactometry calibrate responses` wrote."""

    responses: str


@dataclass(frozen=True)
class TracesTable:
    """Which samples of each touch are kept: of the sensors, and of an output that followed the finger."""

    force: bool = True
    position: bool = True
    emitted: bool = True

    @property
    def kept(self) -> tuple[TraceKind, ...]:
        return tuple(kind for kind in TRACE_KINDS if getattr(self, kind))


@dataclass(frozen=True)
class Devices:
    """The devices of a bench, none of them open."""

    output: Guarded
    force: StreamedSensor | None
    position: StreamedSensor | None
    readers: Mapping[str, Reader]


@dataclass(frozen=True)
class BenchFile:
    """One bench. Its limits stand beside those of the study: the tighter one holds."""

    screen: DisplayTable = field(default_factory=DisplayTable)
    output: OutputPart = field(default_factory=OutputPart)
    limits: Limits | None = None
    sensors: Mapping[str, SensorPart] = field(default_factory=dict)
    force: ForcePart | None = None
    position: PositionPart | None = None
    time_reversal: Learnt | None = None
    traces: TracesTable = field(default_factory=TracesTable)

    def __post_init__(self) -> None:
        for name in ("force", "position"):
            table = getattr(self, name)
            if table is not None and table.sensor not in self.sensors:
                known = tuple(self.sensors) or ("it has none",)
                raise no_such(f"{name}.sensor", table.sensor, "one of the file's sensors", known)

    def limits_with(self, study: Limits) -> Limits:
        """The tighter of both limits."""
        return study if self.limits is None else study.tighter(self.limits)

    def devices(self, study: Limits, today: date, *, touched: bool = True) -> Devices:
        """The devices, to be opened by the bench; `touched` if a finger will be on it.

        Raises
        ------
        InvalidParameter
            If a channel is not one of its sensor, or nothing that knows of the finger gates a connected output that
            is touched.
        DeviceFailed
            If a calibration is older than the file allows, or was not made with this output.
        """
        if touched:  # before a driver is made: nothing plays under a finger that nobody watches
            self.check_gate()
        driver = self.output.settings.driver(self.output.gain)
        if driver.connected and self.output.gain is not None:
            self.output.gain.check("output.gain", self.output.settings.chain(), today)
        limits = self.limits_with(study) if self.limits is not None or not driver.connected else None
        readers = {name: sensor.reader() for name, sensor in self.sensors.items()}
        return Devices(
            Guarded(driver, limits, self.output.load), self._force(readers, today), self._position(readers), readers
        )

    def check_gate(self) -> None:
        """Refuse a connected output that nothing stops when the finger leaves, unless the file says so.

        Raises
        ------
        InvalidParameter
            If there is no force sensor and `ungated` is not stated, or both are, or the sensor is a recording.
        """
        if not self.output.settings.connected:
            return
        if self.force is None:
            sensor = "the sensor that stops the output when the finger leaves; state it, or ungated = true in [output]"
            expect(self.output.ungated, "force", "none", f"{sensor}; nothing was played")
            return
        expect(not self.output.ungated, "output.ungated", "true beside [force]", "one of them")
        recording = f"{self.force.sensor!r}, a recording, which knows of no finger"
        is_live = self.sensors[self.force.sensor].settings.live
        expect(is_live, "force.sensor", recording, "a sensor; nothing was played")

    @property
    def cautions(self) -> tuple[str, ...]:
        """What the file allows and a session should be told."""
        is_shared = getattr(self.output.settings, "shared", False)
        allowed = {
            "output.ungated = true: nothing stops the output when the finger leaves": self.output.ungated,
            "output.shared = true: other programs may play to the output and change its volume": is_shared,
            "force.release = false: a force sensor that is stuck in its band is not found out": not self.release,
        }
        return tuple(f"bench file, {words}" for words, said in allowed.items() if said)

    @property
    def release(self) -> bool:
        """Whether the force must leave its band between touches."""
        return self.force is None or self.force.release

    def _force(self, readers: Mapping[str, Reader], today: date) -> StreamedSensor | None:
        if self.force is None:
            return None
        self.force.calibration.check_age("force", today)
        reader = readers[self.force.sensor]
        reader.check_channels("force.channel", self.force.channel)
        return streamed_force(reader, self.force.channel, self.force.calibration)

    def _position(self, readers: Mapping[str, Reader]) -> StreamedSensor | None:
        if self.position is None:
            return None
        table, reader = self.position, readers[self.position.sensor]
        reader.check_channels("position.channels", *table.channels)
        return streamed_position(reader, table.channels, table.metres_per_count, table.zero_counts)


def device_facts(bench: BenchFile, devices: Devices) -> Facts:
    """What a journal says of the devices: calibrations with date and author, load, counts, delays and drifts."""
    gain, load = bench.output.gain, bench.output.load
    facts: Facts = {
        "output_volts_per_unit": None if gain is None else gain.load_volts_per_unit,
        "output_gain_measured": None if gain is None else _provenance(gain),
        "output_system_volume": None if gain is None else gain.system_volume,
        "output_ungated": bench.output.ungated,
        "output_load": None if load is None else load.kind,
        "output_capacitance_f": None if load is None else load.capacitance_f,
        "ramp_s": bench.output.ramp_s,
        "force_release": bench.release,
        "force_measured": None if bench.force is None else _provenance(bench.force.calibration),
    }
    facts |= {f"output_{name.removeprefix('output_')}": value for name, value in devices.output.driver.facts().items()}
    for sensor, reader in devices.readers.items():
        facts[f"{sensor}_delay_s"] = bench.sensors[sensor].delay_s
        facts |= {f"{sensor}_{name}": value for name, value in reader.facts().items()}
    return facts | _stated(bench)


def _stated(bench: BenchFile) -> Facts:
    """What the file states of screen, sensors and their calibrations, each key on its own, so that a sitting with
    another value can say which."""
    parts = {"screen": bench.screen, "force": bench.force, "position": bench.position, **bench.sensors}
    return {
        f"bench_{part}_{key}": value
        for part, table in parts.items()
        if table is not None
        for key, value in _scalars(asdict(table))
    }


def _scalars(table: Mapping[str, Any]) -> Iterator[tuple[str, Fact]]:
    """The keys of a table and of those within it, with values that a journal holds."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from ((f"{key}_{inner}", fact) for inner, fact in _scalars(value))
        elif value is not None and value != () and value not in (inf, -inf):  # not stated; JSON has no such number
            yield key, value if isinstance(value, bool | int | float | str) else str(value)


def _provenance(measured: Measured) -> str | None:
    said = [str(part) for part in (measured.measured_on, measured.measured_by) if part is not None]
    return " ".join(said) or None


def load_bench(path: Path | None) -> BenchFile:
    """A bench file, or the default bench without one.

    Raises
    ------
    InvalidFile
        If the file cannot be read, or holds anything unknown or impossible.
    """
    if path is None:
        return BenchFile()
    tables = read_table(path, "a bench file")
    with errors_in(path):
        return parse_bench(tables)


def parse_bench(tables: Mapping[str, Any]) -> BenchFile:
    """A bench from the tables of its file.

    Raises
    ------
    InvalidParameter
        If anything is unknown, missing or impossible; the sentence opens with the key path.

    Examples
    --------
    >>> bench = parse_bench({"output": {"kind": "file", "folder": "played"}, "limits": {"voltage_peak_v": "2 kV"}})
    >>> bench.limits.voltage_peak_v
    2000.0
    """
    table = as_si(dict(tables), "")
    assert isinstance(table, dict)
    check_keys(table, _PARTS, "")
    return BenchFile(**{key: _PARTS[key](as_table(part, key), key) for key, part in table.items()})


def _split(table: Mapping[str, Any], names: tuple[str, ...]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The keys of these names, and the others."""
    named = {key: value for key, value in table.items() if key in names}
    return named, {key: value for key, value in table.items() if key not in names}


def _output(table: Mapping[str, Any], path: str) -> OutputPart:
    of_bench, of_device = _split(table, ("gain", "load", "ramp_s", "ungated"))
    device = build_kind({"kind": "null", **of_device}, path, OUTPUTS)
    if of_device.get("kind") == "packed":  # one bit has no ramp
        of_bench = {"ramp_s": 0.0, **of_bench}
    return build(OutputPart, of_bench, path, settings=device)


def _sensors(tables: Mapping[str, Any], path: str) -> dict[str, SensorPart]:
    return {name: _sensor(as_table(table, f"{path}.{name}"), f"{path}.{name}") for name, table in tables.items()}


def _sensor(table: Mapping[str, Any], path: str) -> SensorPart:
    of_bench, of_device = _split(table, ("delay_s",))
    return build(SensorPart, of_bench, path, settings=build_kind(of_device, path, SENSORS))


def _force(table: Mapping[str, Any], path: str) -> ForcePart:
    of_force, of_calibration = _split(table, ("sensor", "channel", "release"))
    return build(ForcePart, of_force, path, calibration=build(ForceCalibration, of_calibration, path))


_PARTS: Mapping[str, Callable[[Mapping[str, Any], str], Any]] = {
    "screen": partial(build, DisplayTable),
    "output": _output,
    "limits": partial(build, Limits),
    "sensors": _sensors,
    "force": _force,
    "position": partial(build, PositionPart),
    "time_reversal": partial(build, Learnt),
    "traces": partial(build, TracesTable),
}
