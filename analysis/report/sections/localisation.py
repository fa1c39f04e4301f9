"""Localisation: correct answers by distance, resolution, and confusions."""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from ...figures import localisation as figures
from ...reading.trials import used_rows
from ...result import Analysis
from ...tasks.goodness import MISFIT
from ...tasks.localisation import CONFUSIONS, DISTANCE, ERROR, ERRORS, OF_PARTICIPANTS, RESOLUTION, TASK, n_alternatives
from ...tasks.signal_detection import forced_choice_sensitivity
from ...wording import interval_text, percent_text
from ..section import Content, Figure, Heading, Lead, ResultKind, Section, TextTable, details, grid, rows_of
from ..texts import caption

MM = {DISTANCE: "distance (mm)", ERROR: "from the correct place (mm)"}


def _sections(analysis: Analysis) -> Iterator[Section]:
    if TASK in analysis.tables:
        rows = used_rows(analysis.trials)
        m, is_one = n_alternatives(rows[rows["task"] == TASK]), analysis.n_participants == 1
        blocks = [*_right(analysis, m, is_one), *_resolution(analysis, m, is_one), *_confused(analysis)]
        yield Section("Localisation", tuple(blocks))


def _right(analysis: Analysis, m: int, is_one: bool) -> Iterator[Content]:
    rates, resolutions = analysis.tables[TASK], analysis.table(RESOLUTION)
    yield Lead(caption("localisation_lead", m, is_one))
    yield grid(_rates_view(rates), analysis.factors)
    if DISTANCE in rates.columns:
        draw = partial(figures.distance_figure, rates, resolutions, 1 / m)
        yield Figure("localisation", draw, caption("distance", is_one, len(resolutions) > 0), TASK)


def _resolution(analysis: Analysis, m: int, is_one: bool) -> Iterator[Content]:
    if RESOLUTION in analysis.tables:
        halfway = (1 + 1 / m) / 2
        sensitivity = forced_choice_sensitivity(halfway, n_alternatives=m)
        yield Heading("Resolution")
        yield Lead(caption("resolution_lead", m, halfway, sensitivity, is_one))
        yield grid(_resolution_view(analysis.tables[RESOLUTION]), analysis.factors)
        participants = _participants_view(analysis.tables[OF_PARTICIPANTS])
        yield details("Participants: resolution", participants, analysis.factors)


def _confused(analysis: Analysis) -> Iterator[Content]:
    draw = partial(figures.confusion_figure, analysis.tables[CONFUSIONS])
    yield Heading("Confusions")
    yield Figure("confusions", draw, caption("confusions"), CONFUSIONS)
    for title, name in (("Confusions", CONFUSIONS), ("Answers by distance from the correct place", ERRORS)):
        if name in analysis.tables:
            yield details(title, _places_view(analysis.tables[name]), analysis.factors)


def _rates_view(rates: pd.DataFrame) -> pd.DataFrame:
    """Format counts (``3 of 4``), rates with intervals, and distances in mm."""
    view = rates.loc[:, :"n_correct"].drop(columns="n_correct")
    view["correct answers"] = [f"{k} of {n}" for k, n in zip(rates["n_correct"], rates["n_trials"], strict=True)]
    view["rate"] = _with_intervals(rates, "rate")
    return _places_view(view)


def _resolution_view(resolutions: pd.DataFrame) -> pd.DataFrame:
    view = resolutions.loc[:, :"mean"].drop(columns="mean")
    view["resolution (mm)"] = _with_intervals(resolutions, "mean", 1e3)
    view["participants"] = resolutions["n"]
    if resolutions["n_missing"].any():
        view["without a resolution"] = resolutions["n_missing"]
    return view


def _participants_view(each: pd.DataFrame) -> pd.DataFrame:
    """Format the resolutions with intervals, and notes if there are any."""
    view = each.loc[:, :"resolution_m"].drop(columns="resolution_m")
    view["resolution (mm)"] = _with_intervals(each, "resolution_m", 1e3)
    view["trials"] = each["n_trials"]
    for name in ("guess_rate", "lapse_rate"):
        rates = each[name].astype(float)
        view[name.replace("_", " ")] = ["" if pd.isna(rate) else percent_text(rate) for rate in rates]
    noted = [name for name in ("note", MISFIT) if (each[name] != "").any()]
    return view.join(each[["status", *noted]])


def _with_intervals(table: pd.DataFrame, name: str, factor: float = 1.0) -> list[str]:
    """Format values times a factor, with their intervals."""
    columns = [name, f"{name}_low", f"{name}_high"]
    rows = (factor * table[columns].astype(float)).itertuples(index=False)
    return ["" if pd.isna(value) else interval_text(value, low, high) for value, low, high in rows]


def _places_view(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(**{name: 1e3 * table[name] for name in MM if name in table.columns}).rename(columns=MM)


def _terminal(analysis: Analysis) -> Iterator[TextTable]:
    if TASK in analysis.tables:
        yield TextTable(_rates_view(analysis.tables[TASK]), "localisation (correct answers, 95 % interval)")
    if RESOLUTION in analysis.tables:
        yield TextTable(_resolution_view(analysis.tables[RESOLUTION]), "resolution (mean, 95 % interval)")


KIND = ResultKind(_sections, _terminal, rows_of(TASK, RESOLUTION, OF_PARTICIPANTS, CONFUSIONS, ERRORS))
