"""Localisation: right answers by distance, resolution, and confusions."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import pandas as pd

from ...figures import localisation as figures
from ...reading.trials import used_rows
from ...result import Analysis
from ...tasks.goodness import MISFIT
from ...tasks.localisation import CONFUSIONS, DISTANCE, ERROR, ERRORS, OF_PARTICIPANTS, RESOLUTION, TASK, n_alternatives
from ...tasks.signal_detection import forced_choice_sensitivity
from ...wording import interval_text, percent_text
from ..section import Content, Details, Figure, Heading, Lead, ResultKind, Section, TextTable, grid, rows_of

RATES = ("guess_rate", "lapse_rate")
MM = {DISTANCE: "distance (mm)", ERROR: "from the right place (mm)"}


def _sections(analysis: Analysis) -> Iterator[Section]:
    if TASK in analysis.tables:
        yield Section("Localisation", (*_right(analysis), *_resolution(analysis), *_confused(analysis)))


def _right(analysis: Analysis) -> Iterator[Content]:
    rates, m, resolutions = analysis.tables[TASK], _n_alternatives(analysis), analysis.table(RESOLUTION)
    together = "one participant" if _is_one(analysis) else "all participants together"
    yield Lead(f"Right answers among {m} alternatives, {together}, with Wilson's 95 % interval; chance is 1/{m}.")
    yield grid(_rates_view(rates), analysis.factors)
    if DISTANCE in rates.columns:
        below = "; at the bottom the resolution with its interval" if len(resolutions) else ""
        text = f"Right answers against the distance between the nearest two places, {together}; bars are Wilson's 95 % "
        draw = partial(figures.distance_figure, rates, resolutions, 1 / m)
        yield Figure("localisation", draw, f"{text}intervals, dotted is chance{below}.", TASK)


def _resolution(analysis: Analysis) -> Iterator[Content]:
    if RESOLUTION not in analysis.tables:
        return
    m = _n_alternatives(analysis)
    half = (1 + 1 / m) / 2
    sensitivity = forced_choice_sensitivity(half, n_alternatives=m)
    over = "of the participant's own fit" if _is_one(analysis) else "over participants"
    yield Heading("Resolution")
    yield Lead(
        f"The distance at which answers are halfway from chance (1/{m}) to the rate that a participant reaches "
        f"(without lapses {percent_text(half)} right, d′ = {sensitivity:.2f}): mean with 95 % interval {over}."
    )
    yield grid(_resolution_view(analysis.tables[RESOLUTION]), analysis.factors)
    each = _participants_view(analysis.tables[OF_PARTICIPANTS])
    yield Details(f"Participants: resolution ({len(each)} rows)", (grid(each, analysis.factors),))


def _confused(analysis: Analysis) -> Iterator[Content]:
    table = analysis.tables[CONFUSIONS]
    text = "Share (%) of each answer among those to each right place."
    yield Heading("Confusions")
    yield Figure("confusions", partial(figures.confusion_figure, table), text, CONFUSIONS)
    for title, name in (("Confusions", CONFUSIONS), ("Answers by their distance from the right place", ERRORS)):
        rows = analysis.table(name)
        if len(rows):
            yield Details(f"{title} ({len(rows)} rows)", (grid(_places_view(rows), analysis.factors),))


def _rates_view(rates: pd.DataFrame) -> pd.DataFrame:
    """Return counts (``3 of 4``), rates with intervals, and distances in millimetres."""
    counts = [f"{k} of {n}" for k, n in zip(rates["n_correct"], rates["n_trials"], strict=True)]
    keys = rates.columns[: rates.columns.get_loc("n_correct")]
    told: dict[str, Any] = {"right answers": counts, "rate": _with_intervals(rates, "rate")}
    return _places_view(rates[keys].assign(**told))


def _resolution_view(resolutions: pd.DataFrame) -> pd.DataFrame:
    keys = resolutions.columns[: resolutions.columns.get_loc("mean")]
    told: dict[str, Any] = {"resolution (mm)": _in_mm(resolutions, "mean"), "participants": resolutions["n"]}
    missing = resolutions["n_missing"]
    return resolutions[keys].assign(**told, **({"without a resolution": missing} if missing.any() else {}))


def _with_intervals(table: pd.DataFrame, name: str) -> list[str]:
    rows = zip(*(table[column] for column in (name, f"{name}_low", f"{name}_high")), strict=True)
    return ["" if pd.isna(value) else interval_text(value, low, high) for value, low, high in rows]


def _places_view(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(**{name: 1e3 * table[name] for name in MM if name in table.columns}).rename(columns=MM)


def _participants_view(each: pd.DataFrame) -> pd.DataFrame:
    """Return resolutions with intervals, and notes if there are any."""
    keys = each.columns[: each.columns.get_loc("resolution_m")]
    shown = ["status", *(name for name in ("note", MISFIT) if (each[name] != "").any())]
    told: dict[str, Any] = {"resolution (mm)": _in_mm(each, "resolution_m"), "trials": each["n_trials"]}
    told |= {
        name.replace("_", " "): ["" if pd.isna(rate) else percent_text(rate) for rate in each[name].astype(float)]
        for name in RATES
    }
    return each[keys].assign(**told, **{name: each[name] for name in shown})


def _in_mm(table: pd.DataFrame, name: str) -> list[str]:
    columns = [name, f"{name}_low", f"{name}_high"]
    return _with_intervals(1e3 * table[columns].astype(float), name)


def _n_alternatives(analysis: Analysis) -> int:
    rows = used_rows(analysis.trials)
    return n_alternatives(rows[rows["task"] == TASK])


def _is_one(analysis: Analysis) -> bool:
    return analysis.trials.rows["participant"].nunique() == 1


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    if TASK in analysis.tables:
        yield TextTable(_rates_view(analysis.tables[TASK]), "localisation (right answers, 95 % interval)")
    if RESOLUTION in analysis.tables:
        yield TextTable(_resolution_view(analysis.tables[RESOLUTION]), "resolution (mean, 95 % interval)")


KIND = ResultKind(_sections, _terminal, rows_of(TASK, RESOLUTION, OF_PARTICIPANTS, CONFUSIONS, ERRORS))
