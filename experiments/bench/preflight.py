"""Preflight: tests of sensors and output before a participant arrives."""

import time
from collections.abc import Iterator
from contextlib import closing
from datetime import date
from pathlib import Path
from typing import Final

import numpy as np

from tactometry.arguments.require import HIGHEST
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import with_ramps
from tactometry.devices.sensors.reader import Reader, SampleBlock
from tactometry.errors import TactometryError
from tactometry.gates import ForceGate
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load
from tactometry.signal import Signal

from ..study.experiment import Experiment, wire
from ..study.felt_effects import predict
from ..study.study_file import folder_of, load
from .bench_file import BenchFile
from .calibration import tone
from .preflight_checks import Finding, computer, disk, display, duration, existing, findings_of, force, position
from .stimuli import bank_on

LISTEN_S = 2.0
RATE_TOLERANCE = 0.02
"""Largest deviation from a sensor's nominal rate, as a share of that rate (unverified default)."""
MAX_GAP_S: Final = ForceGate(target_n=1.0, tolerance=0.1, hold_s=0.0).max_gap_s
LATENCY_AT_MOST_S = 0.02
"""Largest median age of the newest sample when it is read (unverified default)."""
TONE_PART = 0.1
"""Voltage of the test tone, as a share of the limit (unverified default)."""
TONE_S, TONE_RAMP_S = 0.5, 0.1


def check(
    study: str | None, bench: BenchFile, folder: Path, *, hands_off: bool, allow_code: bool = False
) -> list[Finding]:
    """Run all checks in turn, and return each result as a finding.

    - `study`: Name or path of a study. Its limits apply in addition to those of the bench.
    - `folder`: Folder for the data.
    - `hands_off`: True if the experimenter stated that nobody touches the surface. Required for a connected output.
    - `allow_code`: True if custom code named by the study may run.
    """
    findings, experiment = _study(study, allow_code=allow_code) if study is not None else ([], None)
    limits = experiment.study.limits if experiment is not None else bench.limits
    findings += findings_of("computer", computer())
    findings += findings_of("disk", disk(existing(folder)))
    findings += findings_of("display", display(bench.screen, existing(folder)))
    findings += findings_of("devices", devices(bench, limits, experiment, hands_off=hands_off))
    return findings


def _study(study: str, *, allow_code: bool) -> tuple[list[Finding], Experiment | None]:
    try:
        experiment = wire(load(study)[0], study, folder_of(study) if allow_code else None, simulated=False)
    except TactometryError as error:
        return [Finding("study", study, str(error), "a study that can run", fine=False)], None
    n = len(experiment.bank)
    words = f"{n} {'stimulus' if n == 1 else 'stimuli'}; the strongest levels are within the study's limits"
    predicted = predict(experiment)
    allowed = [Finding("study", "caution", caution) for caution in experiment.study.cautions]
    unfelt = [Finding("study", "not felt", line, fine=False) for line in predicted.warnings]
    felt = [Finding("scene", "felt", " ".join(map(str.strip, effects.lines))) for effects in predicted.effects]
    contact = [Finding("finger", f"{finger.force_n:g} N", finger.line) for finger in predicted.fingers]
    return [Finding("study", study, words, fine=True), *allowed, *unfelt, *felt, *contact], experiment


def devices(
    bench: BenchFile, limits: Limits | None, experiment: Experiment | None, *, hands_off: bool
) -> Iterator[Finding]:
    # Without limits, at most 1 V is played. Nobody touches the surface, so no force gate is needed.
    connected = bench.devices(limits or Limits(voltage_peak_v=1.0), date.today(), touched=False)
    for name, reader in connected.readers.items():
        yield from findings_of(f"sensor {name}", _sensor(name, reader))
    if connected.force is not None:
        yield from findings_of("force", force(connected.force))
    yield from findings_of("output", _gate(bench))
    yield from findings_of("position", position(connected, bench, experiment))
    yield from findings_of("output", _output_findings(connected.output, bench, limits, experiment, hands_off=hands_off))


def _sensor(name: str, reader: Reader) -> Iterator[Finding]:
    part, listener = f"sensor {name}", reader.listen()
    with closing(reader):
        reader.open()
        yield Finding(part, "opened", reader.source.name, fine=True)
        ages_s, blocks = [], []
        for block in listener.blocks(time.perf_counter() + LISTEN_S, pause_s=0.002):
            ages_s.append(time.perf_counter() - block.times_s[-1])
            blocks.append(block)
    yield from _stream(part, reader, blocks, ages_s)


def _stream(part: str, reader: Reader, blocks: list[SampleBlock], ages_s: list[float]) -> Iterator[Finding]:
    times_s = np.concatenate([block.times_s for block in blocks]) if blocks else np.empty(0)
    if times_s.size < 2:
        yield Finding(part, "samples", f"{times_s.size} in {LISTEN_S:g} s", "a sensor that sends", False, device=True)
        return
    rate_hz, nominal_hz = (times_s.size - 1) / (times_s[-1] - times_s[0]), reader.source.rate_hz
    fine = bool(abs(rate_hz / nominal_hz - 1) <= RATE_TOLERANCE)
    yield Finding(part, "rate", f"{rate_hz:.1f} Hz", f"{nominal_hz:g} Hz", fine, device=True)
    yield duration(part, "largest gap", float(np.diff(times_s).max()), MAX_GAP_S)
    yield duration(part, "latency, median", float(np.median(ages_s)), LATENCY_AT_MOST_S)
    counted = {key: value for key, value in reader.facts().items() if value not in {None, 0}}
    words = (f"{key} {f'{value:.4g}' if isinstance(value, float) else value}" for key, value in counted.items())
    yield Finding(part, "counts", ", ".join(words))


def _gate(bench: BenchFile) -> Iterator[Finding]:
    for words in bench.cautions:
        yield Finding("output", "caution", words)
    bench.check_gate()


def _output_findings(
    output: Guarded, bench: BenchFile, limits: Limits | None, experiment: Experiment | None, *, hands_off: bool
) -> Iterator[Finding]:
    if output.limits is not None and output.driver.connected:
        yield duration(
            "output", "worst-case stop, from the bench file", bench.stop_delay_s, output.limits.longest_stop_s
        )
    if output.limits is not None and output.load is not None:
        output.limits.check_stated(output.load)
        yield _current_of_a_stop(output, output.limits, output.load)
    yield from findings_of("output", _output(output, limits, hands_off=hands_off))
    if experiment is not None:
        yield from findings_of("output", _strongest(output, experiment, bench))


def _current_of_a_stop(output: Guarded, limits: Limits, load: Load) -> Finding:
    """Report the largest current of a stop, which never fails the check."""
    what = "largest current of a stop, without a limit"
    if output.driver.fall_s == 0:
        return Finding("output", what, "current of one output step, as fast as the amplifier follows")
    voltage_v = min(limits.voltage_peak_v, output.driver.full_scale_v)
    current_a = load.current_peak_a(Signal(np.array([[voltage_v]]), 1 / output.driver.fall_s, "V"))
    return Finding("output", what, f"{current_a:.3g} A from {voltage_v:.3g} V in {1e3 * output.driver.fall_s:g} ms")


def _output(output: Guarded, limits: Limits | None, *, hands_off: bool) -> Iterator[Finding]:
    if limits is None and not output.driver.connected:
        yield Finding("output", "limits", "none stated; name a study or a bench file with limits")
        return
    if output.driver.connected and not hands_off:
        yield Finding("output", "test tone", "not played: the option --hands-off is missing", "--hands-off", fine=False)
        return
    with closing(output):
        output.open()
        yield Finding("output", "opened", output.name, fine=True)
        tested = tone_of(output)
        begin_s = time.perf_counter()
        onset_s = output.play(tested)
        time.sleep(tested.duration_s)
        output.stop()
        stop_delay_s = output.driver.stop_delay_s
    yield Finding("output", "test tone", f"{tested.peak:.3g} V, {tested.duration_s:.3g} s", "within limits", fine=True)
    yield Finding("output", "onset after the call", f"{1e3 * (onset_s - begin_s):.1f} ms")
    if output.limits is not None and output.driver.connected:
        yield duration("output", "worst-case stop, measured", stop_delay_s, output.limits.longest_stop_s)
    n_underruns = output.driver.facts().get("n_underruns")
    if n_underruns is not None:
        yield Finding("output", "underruns", f"{n_underruns}", "0", n_underruns == 0, device=True)


def tone_of(output: Guarded) -> Signal:
    """Return a tone at `TONE_PART` of the limit, or a square wave for one bit."""
    n_channels, rate_hz = output.driver.n_channels or 1, output.driver.rate_hz or 48_000.0
    if output.driver.one_bit:
        bits = np.where(np.arange(1000) // 10 % 2, -1.0, 1.0)
        return Signal(np.tile(bits, (n_channels, 1)) * output.driver.full_scale_v, rate_hz, "V")
    limit_v = output.limits.voltage_peak_v if output.limits is not None else 0.0
    voltage_v = TONE_PART * min(limit_v, output.driver.full_scale_v, HIGHEST["voltage_peak_v"])
    return tone(voltage_v, n_channels, rate_hz, TONE_S, TONE_RAMP_S)


def _strongest(output: Guarded, experiment: Experiment, bench: BenchFile) -> Iterator[Finding]:
    """Check each stimulus at its highest level without playing it."""
    for strongest in experiment.strongest(bank_on(experiment, bench)):
        words, fine, device = f"level {strongest.level:g}", True, False
        try:
            output.check(with_ramps(strongest.signal, bench.output.ramp_s))
        except TactometryError as error:
            words, fine, device = f"{words} of {strongest.name}: {error}", False, error.exit_status == 3
        yield Finding("output", f"strongest {strongest.name}", words, "within limits", fine, device)
