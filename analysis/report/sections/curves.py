"""Rates against the level; psychometric curves and tracks of each participant, and all estimates."""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from ...figures import psychophysics
from ...figures.curves import curve_figure
from ...result import Analysis
from ...tasks.cells import MAX_LEVELS
from ...tasks.kinds import CURVES
from ...tasks.lapses import LAPSES
from ...wording import procedure_name
from ..section import Details, Figure, ResultKind, Section, grid, rows_of

SHOWN = ("threshold", "interval_low", "interval_high", "jnd", "jnd_low", "jnd_high", "width", "guess_rate",
         "lapse_rate", "n_trials", "n_catch", "status", "misfit")  # fmt: skip
"""Columns of estimates on the page; the file has all."""
OF_RULES = ("rule_estimate", "rule_sd", "rule_n")
N_OPEN = 2


def _rate_figures(analysis: Analysis, task: str) -> Iterator[Figure]:
    factors, kind, of = analysis.factors, CURVES[task].rate_label, ("task", task)
    rates, means, counts = (
        table[table["task"] == task] for table in map(analysis.tables.__getitem__, ("rates", "mean_rates", "counts"))
    )
    is_one = counts["participant"].nunique() == 1
    classes = f"; levels in {MAX_LEVELS} classes, each at its mean" if counts["level"].nunique() > MAX_LEVELS else ""
    text = f"{kind} against level, {'one participant' if is_one else 'all participants together'}{classes}."
    yield Figure(
        f"rates_{task}", partial(psychophysics.rate_figure, rates, factors, unit=analysis.unit), text, "rates", of
    )
    # Where levels follow the answers, their mean rate depends on the procedure alone.
    is_tracked = "tracks" in analysis.tables and task in set(analysis.tables["tracks"]["task"])
    if factors and not is_tracked:
        text = f"{kind} over all levels, {'one participant' if is_one else 'mean over participants'}."
        yield Figure(
            f"mean_rates_{task}", partial(psychophysics.mean_rate_figure, means, factors), text, "mean_rates", of
        )


def _sections(analysis: Analysis) -> Iterator[Section]:
    # Cells without a level have catch trials alone.
    tasks = sorted({estimate.cell.task for estimate in analysis.estimates if estimate.cell.levels} & set(CURVES))
    if tasks:
        yield Section("Rates", tuple(figure for task in tasks for figure in _rate_figures(analysis, task)))
    if "thresholds" in analysis.tables:
        drawn = enumerate(_figures(analysis))
        unfolding = (Details(title, (figure,), is_open=n < N_OPEN) for n, (title, figure) in drawn)
        table = analysis.tables["thresholds"]
        of_rules = [name for name in OF_RULES if table[name].notna().any()]
        wanted = ("participant", *analysis.factors, *SHOWN, *of_rules)
        estimates = table[[name for name in wanted if name in table.columns]]
        rows = Details(f"All estimates ({len(estimates)} rows)", (grid(estimates, analysis.factors),))
        yield Section("Participants", (*unfolding, rows))


def _figures(analysis: Analysis) -> Iterator[tuple[str, Figure]]:
    shown = [estimate for estimate in analysis.estimates if estimate.cell.levels]
    for code in sorted({estimate.cell.participant for estimate in shown}):
        estimates = [estimate for estimate in shown if estimate.cell.participant == code]
        draw = partial(curve_figure, estimates, analysis.factors, unit=analysis.unit)
        text = (
            f"{code}: rate at each level (dot size: trials) with Wilson's 95 % interval, fitted curve, and below it "
            "the threshold with its 95 % interval."
        )
        yield f"{code}: psychometric curves", Figure(f"{code}_curves", draw, text, "counts", ("participant", code))
        yield from _tracks(analysis, code)


def _tracks(analysis: Analysis, code: str) -> Iterator[tuple[str, Figure]]:
    rows = analysis.tables.get("tracks", pd.DataFrame({"participant": []}))
    rows = rows[rows["participant"] == code]
    if rows.empty:
        return
    draw = partial(psychophysics.track_figure, rows, analysis.factors, unit=analysis.unit)
    kinds = ", ".join(procedure_name(name) for name in sorted(set(rows["procedure"])))
    filled = " or ".join(CURVES[task].success for task in sorted(set(rows["task"])))
    text = f"{code}: tracks ({kinds}); filled: {filled}, open: not; catch trials and easy trials are left out."
    yield f"{code}: tracks", Figure(f"{code}_tracks", draw, text, "tracks", ("participant", code))


KIND = ResultKind(_sections, values=rows_of("thresholds", LAPSES))
