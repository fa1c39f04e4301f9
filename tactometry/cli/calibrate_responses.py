"""`tactometry calibrate responses`."""

from collections.abc import Mapping
from contextlib import ExitStack
from datetime import date
from pathlib import Path
from typing import Any

from .hands_off import hands_are_off
from .output import check_figure, progress, say, writing


def run(asked: Mapping[str, Any]) -> None:
    """Learn, convert, write and report; `asked` are the command's options."""
    from tactometry.experiments.bench.bench_file import load_bench
    from tactometry.experiments.bench.learning import Learning, Microphone, joined, learn
    from tactometry.stimuli.time_reversal.responses.learning import as_displacement, sequence, sweep, write_learnt

    from ..errors import InvalidParameter, nearest

    check_figure(asked["figure"])
    _check_out(asked["out"])
    bench = load_bench(asked["bench_path"])
    if asked["sensor"] not in bench.sensors:
        raise InvalidParameter(
            f"--sensor: found {asked['sensor']!r}, expected one of {', '.join(bench.sensors)}"
            f"{nearest(asked['sensor'], bench.sensors)}"
        )
    if bench.limits is None:
        raise InvalidParameter("limits: found none in the bench file, expected those of the load; nothing was played")
    devices = bench.devices(bench.limits, date.today(), touched=False)
    reader = devices.readers[asked["sensor"]]
    rate_hz, order = reader.source.rate_hz, asked["sequence_order"]
    low_hz, high_hz = asked["band_hz"]
    if high_hz > rate_hz / 2:
        raise InvalidParameter(
            f"--band-hz: found up to {high_hz:g} Hz, expected at most {rate_hz / 2:g} Hz, half the rate of "
            f"{asked['sensor']!r}"
        )
    excitation = (
        sweep(0.8 * low_hz, min(1.2 * high_hz, rate_hz / 2), rate_hz=rate_hz, duration_s=asked["sweep_s"])
        if order is None
        else sequence(order, rate_hz=rate_hz)
    )
    microphone = Microphone(
        reader, asked["channel"], asked["reference"], asked["units_per_count"], asked["volts_per_count"]
    )
    channels = tuple(k for k in range(devices.output.n_channels or 1) if k != asked["reference_output"])
    learning = Learning(
        excitation, asked["voltage_v"], channels, asked["duration_s"], asked["quantity"], asked["reference_output"]
    )
    _check_hands(asked["hands_off"], connected=bench.output.settings.connected)
    with ExitStack() as last_first:
        reader.open()
        last_first.callback(reader.close)
        last_first.callback(devices.output.close)
        devices.output.open()
        learned = joined(list(progress(learn(learning, devices.output, microphone), len(channels), "learning")))
    found = as_displacement(learned, low_hz, high_hz)
    provenance = {
        "measured_on": str(date.today()),
        "measured_by": asked["by"],
        "output": devices.output.name,
        "sensor": reader.source.name,
        "excitation": excitation.name,
        "voltage_v": asked["voltage_v"],
        "band_hz": f"{low_hz:g} to {high_hz:g}",
        "regularisation": learning.regularisation,
        "recorded_quantity": learned.quantity,
    }
    with writing(asked["out"]):
        write_learnt(found, asked["out"], provenance)
    if asked["figure"] is not None:
        from tactometry.experiments.bench.figures import responses_figure

        with writing(asked["figure"]):
            responses_figure(found, asked["figure"])
    words = f"{asked['out']}: {found.n_channels} responses of {found.duration_s:g} s at {found.rate_hz:g} Hz"
    say(words, {"file": str(asked["out"]), "n_channels": found.n_channels, **provenance}, as_json=asked["as_json"])


def _check_hands(said: bool, *, connected: bool) -> None:
    from ..errors import InvalidParameter

    if connected and not (said or hands_are_off()):
        raise InvalidParameter("--hands-off: found no word that hands are off, expected it; nothing was played")


def _check_out(path: Path) -> None:
    from ..errors import InvalidParameter

    if path.suffix != ".npz" or not path.parent.is_dir():
        raise InvalidParameter(
            f"--out: found {str(path)!r}, expected a name that ends in .npz, in a folder that exists"
        )
