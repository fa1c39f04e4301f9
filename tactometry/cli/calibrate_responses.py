"""`tactometry calibrate responses`."""

from collections.abc import Mapping
from contextlib import ExitStack
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InvalidParameter
from .output import hands_are_off, progress, say, writing

if TYPE_CHECKING:
    from tactometry.experiments.bench.bench_file import BenchFile, Devices
    from tactometry.experiments.bench.learning import Learning
    from tactometry.stimuli.time_reversal.responses.responses import Responses

    from ..devices.outputs.guarded import Guarded
    from ..devices.sensors.reader import Reader


def run(asked: Mapping[str, Any]) -> None:
    """Learn, convert, write and report; `asked` are the command's options."""
    from tactometry.experiments.bench.bench_file import load_bench
    from tactometry.stimuli.time_reversal.responses.learning import as_displacement

    _check_out(asked["out"])
    bench = load_bench(asked["bench_path"])
    devices = _devices(bench, asked["sensor"])
    reader = devices.readers[asked["sensor"]]
    learning = _learning(asked, devices.output.n_channels or 1, reader.source.rate_hz)
    # the last question before anything plays: no gate of force stops a sweep
    _check_hands(asked["hands_off"], connected=bench.output.settings.connected)
    learnt = _learnt(learning, devices.output, reader, asked)
    responses = as_displacement(learnt, *asked["band_hz"])
    provenance = _provenance(asked, learning, devices.output.name, reader.source.name)
    provenance["recorded_quantity"] = learnt.quantity
    _write(responses, provenance, asked["out"], asked["figure"])
    kept = f"{responses.n_channels} responses of {responses.duration_s:g} s at {responses.rate_hz:g} Hz"
    record = {"file": str(asked["out"]), "n_channels": responses.n_channels, **provenance}
    say(f"{asked['out']}: {kept}", record)


def _devices(bench: "BenchFile", sensor: str) -> "Devices":
    from ..arguments.require import one_of

    one_of("--sensor", sensor, bench.sensors)
    if bench.limits is None:
        raise InvalidParameter("limits: found none in the bench file, expected those of the load; nothing was played")
    return bench.devices(bench.limits, date.today(), touched=False)


def _learning(asked: Mapping[str, Any], n_channels: int, rate_hz: float) -> "Learning":
    """What is played, on which channels: a sweep a fifth beyond the band, or a sequence of maximum length."""
    from tactometry.experiments.bench.learning import Learning
    from tactometry.stimuli.time_reversal.responses.learning import sequence, sweep

    low_hz, high_hz = asked["band_hz"]
    if high_hz > rate_hz / 2:
        raise InvalidParameter(
            f"--band-hz: found up to {high_hz:g} Hz, expected at most {rate_hz / 2:g} Hz, half the rate of "
            f"{asked['sensor']!r}"
        )
    if asked["sequence_order"] is None:
        highest_hz = min(1.2 * high_hz, rate_hz / 2)
        excitation = sweep(0.8 * low_hz, highest_hz, rate_hz=rate_hz, duration_s=asked["sweep_s"])
    else:
        excitation = sequence(asked["sequence_order"], rate_hz=rate_hz)
    reference = asked["reference_output"]
    channels = tuple(k for k in range(n_channels) if k != reference)
    return Learning(excitation, asked["voltage_v"], channels, asked["duration_s"], asked["quantity"], reference)


def _learnt(learning: "Learning", output: "Guarded", reader: "Reader", asked: Mapping[str, Any]) -> "Responses":
    from tactometry.experiments.bench.learning import Microphone, join, learn

    counts = asked["units_per_count"], asked["volts_per_count"]
    microphone = Microphone(reader, asked["channel"], asked["reference"], *counts)
    with ExitStack() as last_first:
        reader.open()
        last_first.callback(reader.close)
        # the output is closed first, whatever went wrong: it is the one that plays
        last_first.callback(output.close)
        output.open()
        each_channel = learn(learning, output, microphone)
        return join(list(progress(each_channel, len(learning.channels), "learning")))


def _provenance(asked: Mapping[str, Any], learning: "Learning", output: str, sensor: str) -> dict[str, Any]:
    low_hz, high_hz = asked["band_hz"]
    return {
        "measured_on": str(date.today()),
        "measured_by": asked["by"],
        "output": output,
        "sensor": sensor,
        "excitation": learning.excitation.name,
        "voltage_v": asked["voltage_v"],
        "band_hz": f"{low_hz:g} to {high_hz:g}",
        "regularisation": learning.regularisation,
    }


def _write(responses: "Responses", provenance: Mapping[str, Any], path: Path, figure: Path | None) -> None:
    from tactometry.stimuli.time_reversal.responses.learning import write_learnt

    with writing(path):
        write_learnt(responses, path, provenance)
    if figure is not None:
        from tactometry.experiments.bench.figures import responses_figure

        with writing(figure):
            responses_figure(responses, figure)


def _check_hands(said: bool, *, connected: bool) -> None:
    if connected and not (said or hands_are_off()):
        raise InvalidParameter("--hands-off: found no word that hands are off, expected it; nothing was played")


def _check_out(path: Path) -> None:
    if path.suffix != ".npz" or not path.parent.is_dir():
        raise InvalidParameter(
            f"--out: found {str(path)!r}, expected a name that ends in .npz, in a folder that exists"
        )
