"""`tactometry calibrate`: gain, force sensor, display and responses."""

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import click

from tactometry.experiments.bench import calibration
from tactometry.experiments.bench.bench_file import BenchFile, Devices, load_bench
from tactometry.experiments.bench.bench_table import stated_in, table_toml, write_values
from tactometry.experiments.bench.learning import (
    REPEATABILITY,
    Heard,
    Learning,
    Microphone,
    Quality,
    expect_whole,
    join,
    learn,
    repeatable,
)
from tactometry.stimuli.time_reversal.responses.learning import as_displacement, sequence, sweep, write_learnt

from ..arguments.require import expect, lookup, one_of
from ..devices.outputs.gain import Gain, measured_anew, required_gain
from ..devices.outputs.guarded import Guarded
from ..devices.sensors.reader import Reader
from ..errors import InvalidParameter
from ..loading import resolve
from .output import figure_option, hands_are_off, hands_off_option, path_option, progress, say, subcommand, writing

bench_option = path_option("--bench", "bench_path", required=True, help="Bench file (TOML).")


def _somebody(ctx: click.Context, param: click.Parameter, by: str) -> str:
    del ctx, param
    if not by.strip():
        raise InvalidParameter("--by: found an empty text, expected initials or a code of the experimenter")
    return by.strip()


def _numbers(ctx: click.Context, param: click.Parameter, text: str | None) -> list[float]:
    del ctx
    try:
        return [float(number) for number in text.split(",")] if text else []
    except ValueError:
        raise InvalidParameter(f"{param.opts[0]}: found {text!r}, expected numbers separated by commas") from None


by_option = click.option("--by", required=True, callback=_somebody, help="Initials or code of the experimenter.")
numbers_option = partial(click.option, callback=_numbers)
write_option = click.option("--write", is_flag=True, help="Write the values into the bench file; comments are kept.")
residual_option = click.option(
    "--residual-at-most",
    type=click.FloatRange(0, 1, min_open=True),
    default=calibration.RESIDUAL_AT_MOST,
    help="Largest accepted residual of the fit, relative to the voltage or to the largest force.",
)
TODAY = date.today


@click.group(epilog="Example: tactometry calibrate display --bar-m 0.149")
def command() -> None:
    """Measure values of a bench file, and print or --write them."""


@subcommand("calibrate gain --bench bench.toml --by ZG", command)
@bench_option
@by_option
@numbers_option("--parts", default="0.02,0.05,0.1", help="Amplitudes to play, relative to full scale.")
@numbers_option("--measured-v", metavar="V,V,...", help="Measured peak voltages, V; default: a prompt for each.")
@click.option("--tone-s", type=click.FloatRange(0.1, 30), default=3.0, help="Duration of each tone, s.")
@residual_option
@write_option
def gain(
    *,
    bench_path: Path,
    by: str,
    parts: list[float],
    measured_v: list[float],
    tone_s: float,
    residual_at_most: float,
    write: bool,
) -> None:
    """Measure the output gain with sines of 100 Hz on every channel.

    Enter the peak voltage at the load after each tone. The limits and the gain of the bench file apply during playback.
    Before the first measurement, state the gain of the data sheets in the bench file. With --measured-v nothing is
    played.
    """
    bench = load_bench(bench_path)
    before = required_gain(bench.output.gain, "output.gain")
    new = measured_anew(before, bench.output.settings.chain(), TODAY(), by)
    for share in parts:
        expect(0 < share <= 1, "--parts", f"{share:g}", "fractions of full scale, above 0 and at most 1")
    volts = measured_v or list(_play_and_ask_v(bench, new, parts, tone_s))
    fit = calibration.fit_gain(parts, volts, residual_at_most=residual_at_most)
    values = vars(replace(new, volts_per_unit=fit.volts_per_unit / new.amplifier_gain))
    was = before.load_volts_per_unit
    remark = f"residual rms {fit.residual_rms_v:.3g} V; the file stated {was:.6g} V per unit at the load"
    record = {"volts_per_unit": fit.volts_per_unit, "residual_rms_v": fit.residual_rms_v}
    _tell("output.gain", values, [remark], record, bench_path, write=write)


def _play_and_ask_v(bench: BenchFile, gain: Gain, shares: list[float], tone_s: float) -> Iterator[float]:
    output = _devices(replace(bench, force=None, output=replace(bench.output, gain=gain))).output
    driver = output.driver
    expect(math.isfinite(driver.full_scale_v), "output", f"{output.name!r}, which has no full scale", "audio or ni")
    with closing(output):
        output.open()
        for share in shares:
            click.confirm(f"Play {share:g} of full scale; hands off the surface. Ready?", abort=True, err=True)
            peak_v, n_channels = share * driver.full_scale_v, driver.n_channels or 1
            played = calibration.tone(peak_v, n_channels, driver.rate_hz or 48e3, tone_s, 0.1 * tone_s)
            output.play(played)
            time.sleep(played.duration_s)
            expect_whole(output)
            yield click.prompt("Peak voltage at the load (V)", type=float, err=True)


@subcommand("calibrate force --bench bench.toml --by ZG --weights-kg 0,0.05,0.1,0.2", command)
@bench_option
@by_option
@numbers_option(
    "--weights-kg", required=True, metavar="KG,KG,...", help="Masses, kg, in the order in which you place them."
)
@numbers_option("--counts", metavar="N,N,...", help="Counts for each mass; default: read from the sensor.")
@click.option("--sensor", help="Sensor of the bench file; default: that of [force], or the only one.")
@click.option("--channel", type=int, default=0, help="Channel of the sensor, from 0.")
@click.option("--degree", type=click.IntRange(1, 5), default=1, help="Degree of the polynomial.")
@click.option("--gravity-m-per-s2", type=float, default=9.80665, help="Local acceleration of gravity, m/s^2.")
@figure_option("Write fit and residuals as PNG, PDF or SVG.")
@residual_option
@write_option
def force(
    *,
    bench_path: Path,
    by: str,
    weights_kg: list[float],
    counts: list[float],
    sensor: str | None,
    channel: int,
    degree: int,
    gravity_m_per_s2: float,
    figure: Path | None,
    residual_at_most: float,
    write: bool,
) -> None:
    """Calibrate the force sensor: fit a polynomial to counts of known masses."""
    bench = load_bench(bench_path)
    name = sensor or (bench.force.sensor if bench.force is not None else next(iter(bench.sensors), ""))
    enough = f"at least {degree + 2} for a polynomial of degree {degree}"
    expect(len(weights_kg) >= degree + 2, "--weights-kg", len(weights_kg), enough)
    reader = lookup("--sensor", name, bench.sensors).reader()
    reader.check_channels("--channel", channel)
    counted = counts or _count_weights(reader, channel, weights_kg)
    fit = calibration.fit_force(
        weights_kg, counted, degree=degree, gravity_m_per_s2=gravity_m_per_s2, residual_at_most=residual_at_most
    )
    weights = zip(fit.forces_n, fit.counts, fit.residuals_n, strict=True)
    rows = [f"{f:8.4f} N  {c:12.2f} counts  residual {1e3 * r:+.2f} mN" for f, c, r in weights]
    rows.append(f"residual rms {1e3 * fit.residual_rms_n:.3g} mN")
    values = calibration.force_values(fit, name, channel, TODAY(), by)
    record = {"polynomial": fit.polynomial, "residuals_n": fit.residuals_n.tolist(), "counts": fit.counts.tolist()}
    _tell("force", values, rows, record, bench_path, write=write)
    _draw("force_figure", fit, figure)


def _count_weights(reader: Reader, channel: int, masses_kg: list[float]) -> list[float]:
    with closing(reader):
        reader.open()
        counts = []
        for mass_kg in masses_kg:
            click.confirm(f"Put {mass_kg:g} kg on the sensor and let it rest. Ready?", abort=True, err=True)
            counts.append(calibration.mean_counts(reader, channel))
        return counts


@subcommand("calibrate display --bar-m 0.149", command)
@click.option("--bar-m", type=float, help="Length of the bar, m; default: show the bar, then prompt for it.")
@path_option("--bench", "bench_path", help="Bench file (TOML) for --write.")
@write_option
def display(bar_m: float | None, bench_path: Path | None, *, write: bool) -> None:
    """Measure the display by the length of a white bar.

    The screen shows the bar until you press a key. Then enter its length. The bar is half as high as the screen. With
    --bar-m no window is opened.
    """
    expect(bench_path is not None or not write, "--write", "no bench file", "--bench FILE, the file to write")
    screen = load_bench(bench_path).screen  # report errors of the file before measuring
    result = {"height_m": calibration.display_height_m(_ask_bar_m(screen.screen) if bar_m is None else bar_m)}
    _tell("screen", result, [], result, bench_path, write=write)


def _ask_bar_m(screen: int) -> float:
    """Show the bar, then prompt in the terminal, which a window may hide."""
    from ..rigs.window import Window

    with closing(Window(fullscreen=True, screen=screen)) as window:
        calibration.show_bar(window)
    return float(click.prompt("Length of the bar (m)", type=float, err=True))


@subcommand("calibrate responses --bench bench.toml --by ZG --sensor vibrometer ...", command)
@bench_option
@by_option
@click.option("--sensor", required=True, help="Sensor of the bench file that records the responses.")
@click.option("--channel", type=int, default=0, help="Channel of the vibrometer or accelerometer.")
@click.option("--reference", type=int, default=1, help="Channel that records the drive.")
@click.option("--reference-output", type=int, help="Output channel that is connected to the reference.")
@click.option("--units-per-count", type=float, required=True, help="m, m/s or m/s^2 per count.")
@click.option("--volts-per-count", type=float, required=True, help="V at the load per count of the reference channel.")
@click.option("--quantity", type=click.Choice(["displacement", "velocity", "acceleration"]), default="velocity")
@click.option("--voltage-v", type=float, required=True, help="Peak voltage of the excitation.")
@click.option(
    "--band-hz",
    nargs=2,
    type=float,
    default=(15e3, 70e3),
    help="Band of the responses, Hz; a sweep exceeds it by a fifth.",
)
@click.option("--sweep-s", type=float, default=0.2, help="Duration of the sweep, s.")
@click.option("--sequence-order", type=int, help="Play a maximum-length sequence of this order instead.")
@click.option("--duration-s", type=float, default=0.03, help="Duration of a response, s.")
@click.option("--repeats", type=click.IntRange(2, 100), default=2, help="Number of plays per channel.")
@click.option(
    "--repeatability-at-least",
    type=click.FloatRange(0, 1),
    default=REPEATABILITY,
    help="Smallest accepted repeatability of a channel: the part of a focus that two of its responses share.",
)
@path_option("--out", required=True, help="NPZ file to write.")
@figure_option("Write response and spectra as PNG, PDF or SVG.")
@hands_off_option
@write_option
def responses(**asked: Any) -> None:
    """Learn impulse responses for time reversal on each channel.

    Velocity and acceleration are converted to displacement in the played band. Studies read the file, and so does
    tactometry.stimuli.time_reversal.responses.measured.read.
    """
    out = asked["out"]
    in_place = out.suffix == ".npz" and out.parent.is_dir()
    expect(in_place, "--out", repr(str(out)), "a name that ends in .npz, in an existing folder")
    bench = load_bench(asked["bench_path"])
    one_of("--sensor", asked["sensor"], bench.sensors)
    devices = _devices(bench)
    reader = devices.readers[asked["sensor"]]
    learning = _learning(asked, devices.output.driver.n_channels or 1, reader.source.rate_hz)
    # confirmed last, because no force gate stops a sweep
    if bench.output.settings.connected and not (asked["hands_off"] or hands_are_off()):
        raise InvalidParameter("--hands-off: found no confirmation, expected one before a sweep; nothing was played")
    learned = _learn(learning, devices.output, reader, asked)
    learnt, qualities = join([each.mean for each, _ in learned]), [result for _, result in learned]
    responses = as_displacement(learnt, *asked["band_hz"])
    provenance = _provenance(asked, learning, devices.output.name, reader.source.name)
    provenance["recorded_quantity"] = learnt.quantity
    worst = Quality(*map(min, zip(*qualities, strict=True)))
    provenance |= {"signal_to_noise": _in_db(worst.snr_db), "repeatability": round(worst.repeatability, 6)}
    with writing(out):
        write_learnt(responses, out, provenance)
    _draw("responses_figure", responses, asked["figure"])
    kept = f"{responses.n_channels} responses of {responses.duration_s:g} s at {responses.rate_hz:g} Hz"
    record = {"file": str(out), "n_channels": responses.n_channels, **provenance}
    each = {"channels": [result._asdict() for result in qualities]}
    quality = f"signal to noise: {_in_db(worst.snr_db)}, repeatability: {worst.repeatability:.4f}, of the worst channel"
    remarks = [f"{out}: {kept}", quality]
    _tell("time_reversal", {"responses": str(out)}, remarks, record | each, asked["bench_path"], write=asked["write"])


def _in_db(ratio_db: float) -> str:
    return f"{ratio_db:.1f} dB" if math.isfinite(ratio_db) else "no noise was recorded"


def _tell(
    name: str,
    values: Mapping[str, object],
    remarks: list[str],
    record: Mapping[str, object],
    bench_path: Path | None,
    *,
    write: bool,
) -> None:
    """Print the measured table of the bench file, and write it on request."""
    stated = {} if bench_path is None else stated_in(bench_path, name)
    lines = [table_toml(name, {**stated, **values}), *(f"# {remark}\n" for remark in remarks)]
    written = None
    try:
        if write and bench_path is not None:
            write_values(bench_path, name, values)
            written = str(bench_path)
            lines.append(f"# written into {written}\n")
    finally:  # print the result even if it could not be written
        say("".join(lines).rstrip("\n"), {**record, "written": written})


def _devices(bench: BenchFile) -> Devices:
    """Return the devices of a bench without a participant, within its limits."""
    if bench.limits is None:
        raise InvalidParameter("limits: found none in the bench file, expected limits of the load; nothing was played")
    return bench.devices(bench.limits, TODAY(), touched=False)


def _learning(asked: Mapping[str, Any], n_channels: int, rate_hz: float) -> Learning:
    """Return the excitation, a sweep or a sequence, and its channels."""
    low_hz, high_hz = asked["band_hz"]
    half = f"at most {rate_hz / 2:g} Hz, half the rate of {asked['sensor']!r}"
    expect(high_hz <= rate_hz / 2, "--band-hz", f"up to {high_hz:g} Hz", half)
    if asked["sequence_order"] is None:
        highest_hz = min(1.2 * high_hz, rate_hz / 2)
        excitation = sweep(0.8 * low_hz, highest_hz, rate_hz=rate_hz, duration_s=asked["sweep_s"])
    else:
        excitation = sequence(asked["sequence_order"], rate_hz=rate_hz)
    reference = asked["reference_output"]
    channels = tuple(k for k in range(n_channels) if k != reference)
    how = asked["duration_s"], asked["quantity"], reference
    return Learning(excitation, asked["voltage_v"], channels, *how, n_repeats=asked["repeats"])


def _learn(
    learning: Learning, output: Guarded, reader: Reader, asked: Mapping[str, Any]
) -> list[tuple[Heard, Quality]]:
    counts = asked["units_per_count"], asked["volts_per_count"]
    microphone = Microphone(reader, asked["channel"], asked["reference"], *counts)
    # close the output first on any failure, because it plays
    with closing(reader), closing(output):
        reader.open()
        output.open()
        each_channel = zip(learning.channels, learn(learning, output, microphone), strict=True)
        alike = repeatable(each_channel, asked["band_hz"], asked["repeatability_at_least"])
        return list(progress(alike, len(learning.channels), "learning"))


def _provenance(asked: Mapping[str, Any], learning: Learning, output: str, sensor: str) -> dict[str, Any]:
    low_hz, high_hz = asked["band_hz"]
    return {
        "measured_on": str(TODAY()),
        "measured_by": asked["by"],
        "output": output,
        "sensor": sensor,
        "excitation": learning.excitation.name,
        "voltage_v": asked["voltage_v"],
        "band_hz": f"{low_hz:g} to {high_hz:g}",
        "regularisation": learning.regularisation,
    }


def _draw(figure: str, measured: object, path: Path | None) -> None:
    """Write a figure of `bench.figures` if a file was given."""
    if path is not None:
        with writing(path):
            resolve(f"tactometry.experiments.bench.figures:{figure}")(measured, path)
