"""Rates by level, psychometric functions, tracks and estimates."""

from collections.abc import Iterator
from functools import partial

from ...figures import psychophysics
from ...figures.curves import curve_figure
from ...result import Analysis
from ...tasks.cells import MAX_LEVELS
from ...tasks.kinds import CURVES
from ...tasks.lapses import LAPSES
from ...wording import procedure_name
from ..section import Details, Figure, ResultKind, Section, details, rows_of
from ..texts import caption

SHOWN = ("threshold", "interval_low", "interval_high", "jnd", "jnd_low", "jnd_high", "width", "guess_rate",
         "lapse_rate", "n_trials", "n_catch", "status", "misfit")  # fmt: skip
"""Columns of estimates shown on the page; the CSV file contains all columns."""
OF_RULES = ("rule_estimate", "rule_sd", "rule_n")
N_OPEN = 2


def _sections(analysis: Analysis) -> Iterator[Section]:
    # skip cells that contain only catch trials
    tasks = sorted({estimate.cell.task for estimate in analysis.estimates if estimate.cell.levels} & set(CURVES))
    if tasks:
        yield Section("Rates", tuple(figure for task in tasks for figure in _rate_figures(analysis, task)))
    if "thresholds" in analysis.tables:
        drawn = enumerate(_figures(analysis))
        unfolding = (Details(title, (figure,), is_open=n < N_OPEN) for n, (title, figure) in drawn)
        table = analysis.tables["thresholds"]
        of_rules = [name for name in OF_RULES if table[name].notna().any()]
        columns = ("participant", *analysis.factors, *SHOWN, *of_rules)
        estimates = table[[name for name in columns if name in table.columns]]
        yield Section("Participants", (*unfolding, details("All estimates", estimates, analysis.factors)))


def _rate_figures(analysis: Analysis, task: str) -> Iterator[Figure]:
    factors, label, of_task = analysis.factors, CURVES[task].rate_label, ("task", task)
    tables = (analysis.tables[name] for name in ("rates", "mean_rates", "counts"))
    rates, means, counts = (table[table["task"] == task] for table in tables)
    is_one = counts["participant"].nunique() == 1
    text = caption("rates", label, is_one, MAX_LEVELS if counts["level"].nunique() > MAX_LEVELS else 0)
    draw = partial(psychophysics.rate_figure, rates, factors, unit=analysis.unit)
    yield Figure(f"rates_{task}", draw, text, "rates", of_task)
    # Skip tracks: with adaptive levels the mean rate depends only on the procedure.
    is_tracked = "tracks" in analysis.tables and task in set(analysis.tables["tracks"]["task"])
    if factors and not is_tracked:
        draw = partial(psychophysics.mean_rate_figure, means, factors)
        yield Figure(f"mean_rates_{task}", draw, caption("mean_rates", label, is_one), "mean_rates", of_task)


def _figures(analysis: Analysis) -> Iterator[tuple[str, Figure]]:
    shown = [estimate for estimate in analysis.estimates if estimate.cell.levels]
    for code in sorted({estimate.cell.participant for estimate in shown}):
        estimates = [estimate for estimate in shown if estimate.cell.participant == code]
        draw = partial(curve_figure, estimates, analysis.factors, unit=analysis.unit)
        of_code = ("participant", code)
        yield f"{code}: psychometric curves", Figure(f"{code}_curves", draw, caption("curves", code), "counts", of_code)
        if "tracks" in analysis.tables and code in set(analysis.tables["tracks"]["participant"]):
            yield f"{code}: tracks", _track_figure(analysis, code)


def _track_figure(analysis: Analysis, code: str) -> Figure:
    rows = analysis.tables["tracks"]
    rows = rows[rows["participant"] == code]
    procedures = [procedure_name(name) for name in sorted(set(rows["procedure"]))]
    successes = [CURVES[task].success for task in sorted(set(rows["task"]))]
    draw = partial(psychophysics.track_figure, rows, analysis.factors, unit=analysis.unit)
    text = caption("tracks", code, procedures, successes)
    return Figure(f"{code}_tracks", draw, text, "tracks", ("participant", code))


KIND = ResultKind(_sections, values=rows_of("thresholds", LAPSES))
