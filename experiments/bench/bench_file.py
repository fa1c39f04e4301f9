"""Bench files, and the strict parser that reads them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from datetime import date
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, TypeVar

from tactometry.arguments.require import Unlimited, expect, warning_of
from tactometry.config.quantity import as_si
from tactometry.config.strict import as_table, build, build_kind, check_keys, values_of
from tactometry.config.toml import errors_in, read_table
from tactometry.devices.kinds import OUTPUTS, SENSORS
from tactometry.devices.measured import Measured
from tactometry.devices.outputs.emission_ledger import Ledger, default_path
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.streamed import ForceCalibration, StreamedSensor, streamed_force, streamed_position
from tactometry.errors import Gathered
from tactometry.safety.limits import Limits
from tactometry.session.request import Fact, Facts

from ..study.study import no_such
from .bench_parts import DisplayTable, ForcePart, Learnt, OutputPart, PositionPart, SensorPart, TracesTable

T = TypeVar("T")


@dataclass(frozen=True)
class Devices:
    """Devices of a bench, not yet opened."""

    output: Guarded
    force: StreamedSensor | None
    position: StreamedSensor | None
    readers: Mapping[str, Reader]


@dataclass(frozen=True)
class BenchFile:
    """Contents of a bench file. The tighter limits of bench and study apply.

    - `screen`: Screen on which the participant reads and answers.
    - `output`: Device that plays the stimuli.
    - `limits`: Limits for every signal. Required if an output is connected.
    - `sensors`: Sensors by name. You choose the names.
    - `force`: Force sensor and its calibration. Required if an output is connected, unless the output is `ungated`.
    - `position`: Sensor of the finger's position, with its calibration.
    - `time_reversal`: Measured impulse responses of this bench. They replace those of the model.
    - `traces`: Kinds of samples that a session stores.
    """

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
                raise no_such(f"{name}.sensor", table.sensor, "one of the sensors of this file", known)

    def limits_with(self, study: Limits) -> Limits:
        """Return the tighter limits of bench and study."""
        return study if self.limits is None else study.tighter(self.limits)

    def devices(self, study: Limits, today: date, *, touched: bool = True) -> Devices:
        """Create the devices without opening them.

        `touched` states whether a finger will touch the surface.

        Raises `InvalidParameter` if a sensor has no such channel, or no sensor gates a connected output that is
        touched. Raises `DeviceFailed` if a calibration is older than the file allows, or was not made with this output.
        """
        if touched:  # checked before any driver is created
            self.check_gate()
            self.check_stop(study)
        driver = self.output.settings.driver(self.output.gain)
        if driver.connected and self.output.gain is not None:
            self.output.gain.check("output.gain", self.output.settings.chain(), today)
        limits = self.limits_with(study) if self.limits is not None or not driver.connected else None
        readers = {name: sensor.reader() for name, sensor in self.sensors.items()}
        ledger = Ledger(default_path()) if driver.emits else None
        return Devices(
            Guarded(driver, limits, self.output.load, ledger=ledger),
            self._force(readers, today),
            self._position(readers),
            readers,
        )

    def check_gate(self) -> None:
        """Reject a connected output that no sensor can stop.

        Raises `InvalidParameter` if neither a force sensor nor `ungated` is stated, or both are, or the sensor is a
        recording.
        """
        if not self.output.settings.connected:
            return
        if self.force is None:
            sensor = "a force sensor that stops the output when the finger leaves, or ungated = true in [output]"
            expect(self.output.ungated, "force", "none", f"{sensor}; nothing was played")
            return
        expect(not self.output.ungated, "output.ungated", "true together with [force]", "only one of them")
        recording = f"{self.force.sensor!r}, a recording, which cannot detect a finger"
        is_live = self.sensors[self.force.sensor].settings.live
        expect(is_live, "force.sensor", recording, "a live sensor; nothing was played")

    def check_stop(self, study: Limits) -> None:
        """Raise `LimitExceeded` if a connected output may stop too late."""
        if self.output.settings.connected:
            self.limits_with(study).check_stop(self.stop_delay_s)

    @property
    def stop_delay_s(self) -> float:
        """Worst-case delay (s) of stopping the output, from the bench file."""
        return self.output.settings.driver(self.output.gain).stop_delay_s

    @property
    def cautions(self) -> tuple[str, ...]:
        """Warnings about permissive settings of the bench file."""
        is_shared = getattr(self.output.settings, "shared", False)
        allowed = {
            "output.ungated = true: nothing stops the output when the finger leaves": self.output.ungated,
            "output.shared = true: other programs may play to the output and change its volume": is_shared,
            "force.release = false: a force sensor that is stuck within its band is not detected": not self.release,
        }
        measured = {"output.gain": self.output.gain, "force": None if self.force is None else self.force.calibration}
        ages = [part for part, one in measured.items() if one is not None and isinstance(one.max_age_days, Unlimited)]
        limits = () if self.limits is None else self.limits.switched_off
        unlimited = (*(f"limits.{name}" for name in limits), *(f"{part}.max_age_days" for part in ages))
        permitted = [words for words, is_said in allowed.items() if is_said]
        return tuple(f"bench file, {words}" for words in (*permitted, *map(warning_of, unlimited)))

    @property
    def release(self) -> bool:
        """True if the force must leave its band between touches."""
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
        known = (table.count_low, table.count_high)
        return streamed_position(reader, table.channels, table.metres_per_count, table.zero_counts, known)


def device_facts(bench: BenchFile, devices: Devices) -> Facts:
    """Return facts about devices and calibrations for the journal."""
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
    """Return values of the bench file to compare with later sittings."""
    parts = {"screen": bench.screen, "force": bench.force, "position": bench.position, **bench.sensors}
    return {
        f"bench_{part}_{key}": value
        for part, table in parts.items()
        if table is not None
        for key, value in _scalars(asdict(table))
    }


def _scalars(table: Mapping[str, Any]) -> Iterator[tuple[str, Fact]]:
    """Yield those values of nested tables that a journal can store."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from ((f"{key}_{inner}", fact) for inner, fact in _scalars(value))
        elif isinstance(value, Unlimited):
            yield key, str(value)
        elif value is not None and value != () and value not in (inf, -inf):  # JSON has no infinity
            yield key, value if isinstance(value, bool | int | float | str) else str(value)


def _provenance(measured: Measured) -> str | None:
    parts = [str(part) for part in (measured.measured_on, measured.measured_by) if part is not None]
    return " ".join(parts) or None


def load_bench(path: Path | None) -> BenchFile:
    """Read a bench file, or return the default bench without one.

    Raises `InvalidFile` if the file cannot be read, or a key or value is invalid.
    """
    if path is None:
        return BenchFile()
    tables = read_table(path, "a bench file")
    with errors_in(path):
        return parse_bench(tables)


def parse_bench(tables: Mapping[str, Any]) -> BenchFile:
    """Build a bench from the tables of its file.

    Raises `InvalidParameter` if a key or value is invalid; the message starts with the key path.

    Examples
    --------
    >>> bench = parse_bench({"output": {"kind": "file", "folder": "played"}, "limits": {"voltage_peak_v": "2 kV"}})
    >>> bench.limits.voltage_peak_v
    2000.0
    """
    mistakes, parts = Gathered(), {}
    table = as_si(dict(tables), "", mistakes)
    with mistakes.part():
        check_keys(table, _PARTS, "", read_by=BenchFile)
    for key in filter(_PARTS.__contains__, table):
        with mistakes.part():
            parts[key] = _PARTS[key](as_table(table[key], key), key)
    mistakes.end()
    return BenchFile(**parts)


def _split(table: Mapping[str, Any], names: tuple[str, ...]) -> tuple[dict[str, Any], dict[str, Any]]:
    named = {key: value for key, value in table.items() if key in names}
    return named, {key: value for key, value in table.items() if key not in names}


def _part(kind: type[T], table: Mapping[str, Any], path: str, **inner: Callable[[], object]) -> T:
    """Build a part of the bench with its inner parts, and report all mistakes."""
    mistakes, made = Gathered(), {}
    for name, build_inner in inner.items():
        with mistakes.part():
            made[name] = build_inner()
    with mistakes.part():
        values_of(kind, table, path, inner)
    mistakes.end()
    return build(kind, table, path, **made)


def _output(table: Mapping[str, Any], path: str) -> OutputPart:
    of_bench, of_device = _split(table, ("gain", "load", "ramp_s", "ungated"))
    if of_device.get("kind") == "packed":  # a one-bit signal has no ramp
        of_bench = {"ramp_s": 0.0, **of_bench}
    return _part(OutputPart, of_bench, path, settings=lambda: build_kind({"kind": "null", **of_device}, path, OUTPUTS))


def _sensors(tables: Mapping[str, Any], path: str) -> dict[str, SensorPart]:
    mistakes, sensors = Gathered(), {}
    for name, table in tables.items():
        with mistakes.part():
            sensors[name] = _sensor(as_table(table, f"{path}.{name}"), f"{path}.{name}")
    mistakes.end()
    return sensors


def _sensor(table: Mapping[str, Any], path: str) -> SensorPart:
    of_bench, of_device = _split(table, ("delay_s",))
    return _part(SensorPart, of_bench, path, settings=lambda: build_kind(of_device, path, SENSORS))


def _force(table: Mapping[str, Any], path: str) -> ForcePart:
    of_force, of_calibration = _split(table, ("sensor", "channel", "release"))
    return _part(ForcePart, of_force, path, calibration=lambda: build(ForceCalibration, of_calibration, path))


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
