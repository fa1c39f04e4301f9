"""Reference tables of a bench file."""

from collections.abc import Iterator, Mapping
from datetime import date
from functools import partial
from typing import Any, Final

from tactometry.devices.kinds import OUTPUTS, SENSORS
from tactometry.loading import resolve

from .study_tables import limits
from .tables import KeyTable, Values

_OUTPUTS: Final[Mapping[str, Values]] = {
    "file": {"folder": "played"},
    "packed": {"path": "/dev/board", "n_channels": 33, "rate_hz": 250e3},
    "audio": {"device": "Interface", "rate_hz": 192e3},
    "ni": {"channels": ["Dev1/ao0"], "rate_hz": 250e3},
}
_OF_OUTPUT: Final[Values] = {
    "n_channels": 1, "rate_hz": 192e3, "electrode": 32, "lowest_supply_v": 20.0, "position_latency_s": 0.06,
}  # fmt: skip
_SENSORS: Final[Mapping[str, Values]] = {
    "lsl": {"stream": "force", "rate_hz": 1e3},
    "serial": {"port": "/dev/ttyACM0", "rate_hz": 1e3},
    "udp": {"address": "192.168.1.1", "rate_hz": 1e3},
    "audio": {"device": "Interface", "rate_hz": 48e3},
    "touch": {"path": "/dev/input/event5"},
    "recorded": {"path": "force.csv", "rate_hz": 1e3},
}
_MEASURED: Final[Values] = {"measured_on": date(2026, 11, 20), "measured_by": "ZG"}
_GAIN: Final[Values] = {"volts_per_unit": 2.0, "amplifier_gain": 100.0}
_OF_GAIN: Final[Values] = {**_MEASURED, "measured_with": "audio Interface, int32", "system_volume": 1.0}
_LOAD: Final[Values] = {"kind": "electrode", "capacitance_f": 3e-10}
_FORCE: Final[Values] = {"newtons_per_count": 0.01}
_OF_FORCE: Final[Values] = {**_MEASURED, "max_age_days": 90, "count_low": 0.0, "count_high": 4095.0}
_BY_TABLE: Final[Values] = {"table_counts": [0.0, 100.0], "table_forces_n": [0.0, 1.0]}
_PIEZO: Final[Values] = {"kind": "piezo", "capacitance_f": 5e-9, "displacement_m_per_v": [1e-8]}


def bench_tables() -> Iterator[KeyTable]:
    """Yield the reference tables of a bench file, in the order of its parts."""
    parts = "tactometry.experiments.bench.bench_parts"
    yield KeyTable("bench", "", "tactometry.experiments.bench.bench_file:BenchFile")
    yield KeyTable("bench.screen", "[screen]", f"{parts}:DisplayTable", samples={"height_m": 0.298})
    null = partial(_built, OUTPUTS["null"])
    yield KeyTable("bench.output", "[output]", f"{parts}:OutputPart", given=lambda: {"settings": null()})
    yield from map(_output, OUTPUTS)
    gain, load = "tactometry.devices.outputs.gain:Gain", "tactometry.safety.load:Load"
    yield KeyTable("bench.output.gain", "[output.gain]", gain, example=_GAIN, samples=_OF_GAIN)
    piezo = {"displacement_m_per_v": _PIEZO}
    yield KeyTable("bench.output.load", "[output.load]", load, example=_LOAD, instead=piezo)
    yield limits("bench.limits", "[limits]")
    sensor = partial(_built, SENSORS["touch"], **_SENSORS["touch"])
    header = "[sensors.NAME]"
    yield KeyTable("bench.sensors", header, f"{parts}:SensorPart", given=lambda: {"settings": sensor()})
    yield from map(_sensor, SENSORS)
    yield from _measurements(parts)
    learnt = {"responses": "learnt.npz"}
    yield KeyTable("bench.time_reversal", "[time_reversal]", f"{parts}:Learnt", example=learnt)
    yield KeyTable("bench.traces", "[traces]", f"{parts}:TracesTable")


def _measurements(parts: str) -> Iterator[KeyTable]:
    """Yield the tables of force and position."""
    calibration = "tactometry.devices.sensors.streamed:ForceCalibration"
    yield KeyTable(
        "bench.force",
        "[force]",
        f"{parts}:ForcePart",
        example={"sensor": "hand"},
        also=("bench.force.calibration",),
        given=lambda: {"calibration": _built(calibration, **_FORCE)},
    )
    yield KeyTable(
        "bench.force.calibration",
        "[force]",
        calibration,
        example=_FORCE,
        samples=_OF_FORCE,
        instead={"polynomial": {"polynomial": [-0.5, 0.01]}, **dict.fromkeys(_BY_TABLE, _BY_TABLE)},
    )
    place = {"sensor": "hand", "channels": [0, 1], "metres_per_count": 1e-6}
    zeros = {"zero_counts": [0.0, 0.0], "count_low": 0.0, "count_high": 254.0}
    yield KeyTable("bench.position", "[position]", f"{parts}:PositionPart", example=place, samples=zeros)


def _output(kind: str) -> KeyTable:
    return KeyTable(
        f"bench.output.{kind}",
        "[output]",
        OUTPUTS[kind],
        kind,
        usual=kind == "null",
        example=_OUTPUTS.get(kind, {}),
        samples=_OF_OUTPUT,
        also=("bench.output",),
    )


def _sensor(kind: str) -> KeyTable:
    return KeyTable(
        f"bench.sensors.{kind}",
        "[sensors.NAME]",
        SENSORS[kind],
        kind,
        example=_SENSORS.get(kind, {}),
        samples={"source_id": "F7-0042"},
        also=("bench.sensors",),
    )


def _built(target: str, **values: Any) -> object:
    return resolve(target)(**values)
