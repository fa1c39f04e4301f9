"""The report: one HTML file that needs nothing else, its tables beside it."""

import re
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.analysis import figures
from tactometry.analysis.cells import FITTED_TASKS, Estimate, _is_catch, _yes
from tactometry.analysis.pipeline import Analysis, Outcome
from tactometry.analysis.table import used_rows
from tactometry.errors import DeviceFailed, InvalidParameter

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
PDF_TIMEOUT_S = 120.0
NAMES = {
    "threshold": "Detection threshold",
    "pse": "Point of subjective equality",
    "jnd": "Just noticeable difference",
}


@dataclass(frozen=True)
class Figure:
    """An SVG element with what it shows, and the table that holds its numbers."""

    svg: str
    caption: str
    table: str
    summary: str = ""


@dataclass(frozen=True)
class Grid:
    """A table as text."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def write_report(found: Analysis, path: Path, *, pdf: bool = False) -> Analysis:
    """Write the report to `path`, its tables to the folder ``<stem>_tables``, and a PDF if asked for.

    Raises
    ------
    InvalidParameter
        If `path` does not end in ``.html``.
    DeviceFailed
        If something cannot be written or printed.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        raise InvalidParameter(f"--report: found {path.name!r}, expected a file name that ends in .html")
    folder = path.with_name(f"{path.stem}_tables")
    page = render(found)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, table in found.tables.items():
            (folder / f"{name}.csv").write_text(table.to_csv(index=False, lineterminator="\n"), encoding="utf-8")
        path.write_text(page, encoding="utf-8")
    except OSError as failure:
        raise DeviceFailed(f"{failure.filename or path}: cannot be written ({failure.strerror})") from None
    if pdf:
        print_pdf(path)
    return replace(found, report=path, tables_folder=folder)


def render(found: Analysis) -> str:
    """The whole page; the same data give the same text."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string((files("tactometry.analysis") / "report.html").read_text("utf-8"))
    drawn = _numbered(_figures(found))
    return template.render(
        analysis=found,
        title=_title(found),
        names=NAMES,
        outcomes=[(outcome, _grid(outcome.cross), _anova_grid(outcome)) for outcome in found.outcomes],
        figures=drawn,
        quality=_grid(found.tables["quality"]),
        thresholds=_grid(_short_thresholds(found)),
    )


def _title(found: Analysis) -> str:
    rows = found.trials.rows
    studies = sorted(set(rows["study"])) if "study" in rows.columns else []
    return ", ".join(study for study in studies if study) or found.trials.path.stem


def _numbered(drawn: Sequence[Figure]) -> list[Figure]:
    """Element names are made unique in the page: a reference must not reach into another figure."""
    return [
        replace(figure, svg=re.sub(r'(\bid="|href="#|url\(#)', rf"\1f{place}-", figure.svg))
        for place, figure in enumerate(drawn)
    ]


def _figures(found: Analysis) -> list[Figure]:
    factors = found.trials.factors
    drawn = [_outcome_figure(found, outcome) for outcome in found.outcomes]
    tasks = {outcome.task for outcome in found.outcomes}
    for task in sorted(tasks):
        drawn += _rate_figures(found, task)
    for code in sorted({estimate.cell.participant for estimate in found.estimates}):
        own = [estimate for estimate in found.estimates if estimate.cell.participant == code]
        drawn += [_curves(own, factors, found.unit, code)]
        drawn += _tracks(found, code)
    return drawn


def _outcome_figure(found: Analysis, outcome: Outcome) -> Figure:
    name = NAMES[outcome.dependent]
    svg = figures.threshold_figure(
        outcome.group,
        found.trials.factors,
        label=f"{name} ({found.unit})" if found.unit else name,
        individuals=outcome.estimates,
        dependent=outcome.dependent,
    )
    text = f"{name}: means over participants with 95 % t-intervals; faint dots are participants, open triangles bounds."
    return Figure(svg, text, f"group_{outcome.dependent}")


def _rate_figures(found: Analysis, task: str) -> list[Figure]:
    factors = found.trials.factors
    rates, means = (table[table["task"] == task] for table in (found.tables["rates"], found.tables["mean_rates"]))
    kind = figures.RATE_LABEL[task]
    drawn = [
        Figure(
            figures.rate_figure(rates, factors, unit=found.unit),
            f"{kind} against level, all participants together.",
            "rates",
        )
    ]
    if factors:
        text = f"{kind} over all levels, mean over participants."
        drawn.append(Figure(figures.mean_rate_figure(means, factors), text, "mean_rates"))
    return drawn


def _curves(own: Sequence[Estimate], factors: Sequence[str], unit: str, code: str) -> Figure:
    svg = figures.curve_figure(own, factors, unit=unit)
    text = (
        f"{code}: rate at each level (dot size: trials) with Wilson's 95 % interval, fitted curve, and below it the "
        "threshold with its 95 % interval."
    )
    return Figure(svg, text, "thresholds", f"{code}: psychometric curves")


def _tracks(found: Analysis, code: str) -> list[Figure]:
    rows = used_rows(found.trials)
    if "procedure" not in rows.columns:
        return []
    rows = rows[
        (rows["participant"] == code)
        & rows["task"].isin(FITTED_TASKS)
        & ~rows["procedure"].isin(["constant", "constant_stimuli"])
        & ~_is_catch(rows)
    ]
    if rows.empty:
        return []
    svg = figures.track_figure(rows.assign(yes=_yes(rows)), found.trials.factors, unit=found.unit)
    text = f"{code}: staircases; filled: yes or correct, open: not; catch trials are left out."
    return [Figure(svg, text, "", f"{code}: tracks")]


def _short_thresholds(found: Analysis) -> pd.DataFrame:
    table = found.tables["thresholds"]
    wanted = ["participant", *found.trials.factors, "threshold", "interval_low", "interval_high", "jnd", "jnd_low"]
    wanted += ["jnd_high", "width", "guess_rate", "lapse_rate", "n_trials", "n_catch", "status"]
    return table[[name for name in wanted if name in table.columns]]


def _anova_grid(outcome: Outcome) -> Grid | None:
    return None if outcome.anova is None else _grid(outcome.anova)


def _grid(table: pd.DataFrame) -> Grid:
    rows = tuple(tuple(_cell(value) for value in row) for row in table.itertuples(index=False, name=None))
    return Grid(tuple(str(name) for name in table.columns), rows)


def _cell(value: object) -> str:
    if value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value)):
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def print_pdf(path: Path) -> Path:
    """Print the page to a PDF beside it through an installed browser.

    Raises
    ------
    DeviceFailed
        If there is no browser, or it fails.
    """
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if browser is None:
        raise DeviceFailed(f"--pdf: found no browser ({', '.join(BROWSERS)}), expected one; print {path} by hand")
    target = path.with_suffix(".pdf").resolve()
    with tempfile.TemporaryDirectory() as profile:
        options = (
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-pdf-header-footer",
            f"--user-data-dir={profile}",
        )
        done = subprocess.run(
            [browser, *options, f"--print-to-pdf={target}", path.resolve().as_uri()],
            capture_output=True,
            timeout=PDF_TIMEOUT_S,
            check=False,
        )
    if done.returncode != 0 or not target.exists():
        raise DeviceFailed(f"--pdf: {browser} ended with status {done.returncode}; print {path} by hand")
    return target
