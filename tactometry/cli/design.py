"""`tactometry design`."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from tactometry.stimuli.time_reversal.design.guide import OFF, Target, Transducers
from tactometry.stimuli.time_reversal.design.thickness import SHEETS_M, SMALL, Sheet, best_sheet, sheets
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN, read_plate

from .output import figure_option, path_option, say, subcommand, writing


@subcommand("design --contrast 15 --amplitude-m 10e-6 --repetition-hz 100")
@path_option("--plate", "plate_file", help="TOML file of a plate; default: A4, 1.1 mm.")
@click.option("--transducers", default=32, help="Number of patches.")
@click.option("--patch-m", default=10e-3, help="Side of a patch, m.")
@click.option("--voltage-v", default=30.0, help="Peak voltage of the one-bit drive, V.")
@click.option("--band-hz", nargs=2, type=float, default=(20e3, 60e3), help="Lowest and highest frequency, Hz.")
@click.option("--tau-s", default=3.5e-3, help="Attenuation constant, s.")
@click.option("--resolution-m", type=float, help="Target: largest width of the focus at -6 dB, m.")
@click.option("--contrast", type=float, help="Target: smallest ratio of focus amplitude to rms of the plate.")
@click.option("--amplitude-m", type=float, help="Target: smallest displacement at the focus, m.")
@click.option("--repetition-hz", type=float, help="Target: foci per second.")
@click.option(
    "--thickness-m", type=float, multiple=True, help="Available thickness, m; may be repeated; default: glass as sold."
)
@figure_option("Write the trade-offs as PNG, PDF or SVG, and the trade-offs of thickness to NAME_thickness.")
def command(
    *,
    plate_file: Path | None,
    transducers: int,
    patch_m: float,
    voltage_v: float,
    band_hz: tuple[float, float],
    tau_s: float,
    resolution_m: float | None,
    contrast: float | None,
    amplitude_m: float | None,
    repetition_hz: float | None,
    thickness_m: tuple[float, ...],
    figure: Path | None,
) -> int:
    """Design a time-reversal screen for your targets.

    The result contains reversal time, repetition time, transducers, band and thickness. The thickness of the plate is
    kept if it reaches the targets. Otherwise the best available sheet is chosen.

    Exit status 1 if a target cannot be reached; the output states the reason.
    """
    plate = A4_SCREEN if plate_file is None else read_plate(plate_file)
    among = sheets(
        plate,
        Transducers(transducers, patch_m, voltage_v=voltage_v),
        Band(*band_hz),
        tau_s,
        Target(resolution_m, contrast, amplitude_m, repetition_hz),
        thickness_m or SHEETS_M,
    )
    best = best_sheet(among, plate.thickness_m)
    if figure is not None:
        _write_figures(best, among, figure)
    all_sheets = {"thicknesses": [_record(sheet) for sheet in among], "simulation_over_law": {**OFF}}
    say(_text(best, among), _record(best) | all_sheets)
    return 1 if best.unreachable else 0


def _write_figures(best: Sheet, among: Sequence[Sheet], figure: Path) -> None:
    from tactometry.stimuli.time_reversal.figures.theory import over_thickness, save, trade_offs

    with writing(figure):
        save(trade_offs(best.guide), figure)
        save(over_thickness(among, best), figure.with_stem(f"{figure.stem}_thickness"))


def _text(best: Sheet, among: Sequence[Sheet]) -> str:
    record = _record(best)
    numbers = {name: value for name, value in record.items() if type(value) in {float, int}}
    if not best.bends_linearly:
        del numbers["deflection_m"]
    lines = [f"{name:<16}{value:.6g}" for name, value in numbers.items()]
    notes = [f"note: {note}" for note in best.guide.notes] + [f"not reached: {why}" for why in best.unreachable]
    return "\n".join([*lines, *notes, "", *_trade_off(best, among), "", *_how_far_off(among)])


def _trade_off(best: Sheet, among: Sequence[Sheet]) -> Iterator[str]:
    yield "  thickness  resolution  contrast  amplitude    Q  mean frequency  stress   bends    not reached"
    for sheet in among:
        design, mark = sheet.guide.design, "*" if sheet is best else " "
        missed = ", ".join(why.partition(":")[0] for why in sheet.unreachable)
        yield (
            f"{mark} {sheet.thickness_m * 1e3:6.2f} mm {design.resolution_m * 1e3:8.1f} mm {design.contrast:9.1f} "
            f"{design.amplitude_m * 1e6:7.2f} um {design.transducers.n:4d} {design.band.mean_hz / 1e3:11.1f} kHz "
            f"{sheet.stress_pa / 1e6:5.1f} MPa {_bends(sheet):>9}  {missed}"
        )


def _bends(sheet: Sheet) -> str:
    """Format the deflection, or state that the law does not apply."""
    if sheet.bends_linearly:
        return f"{sheet.deflection_m * 1e6:.0f} um"
    return f"> {SMALL * sheet.thickness_m * 1e6:.0f} um"


def _how_far_off(among: Sequence[Sheet]) -> Iterator[str]:
    ranges = ", ".join(f"{name} {low:+.0%} to {high:+.0%}" for name, (low, high) in OFF.items())
    yield f"ratio of simulation to these laws: {ranges}; smaller differences between sheets are not meaningful"
    if len(among) > 1:
        yield "amplitudes follow from the moment per volt of a patch (calibrated: 10 um on A4 of 1.1 mm at 30 V)"
        yield "which is assumed to be the same on every sheet (unverified)"
    if not all(sheet.bends_linearly for sheet in among):
        yield "> : above half of the thickness, where the law of small deflections fails; the stress is an upper bound"


def _record(sheet: Sheet) -> dict[str, object]:
    guide, design = sheet.guide, sheet.guide.design
    return {
        "reversal_s": design.reversal_s,
        "repetition_s": design.repetition_s,
        "n_transducers": design.transducers.n,
        "f_min_hz": design.band.f_min_hz,
        "f_max_hz": design.band.f_max_hz,
        "thickness_m": design.plate.thickness_m,
        "resolution_m": design.resolution_m,
        "contrast": design.contrast,
        "amplitude_m": design.amplitude_m,
        "stress_pa": sheet.stress_pa,
        "deflection_m": sheet.deflection_m,
        "bends_linearly": sheet.bends_linearly,
        "notes": list(guide.notes),
        "unreachable": list(sheet.unreachable),
    }
