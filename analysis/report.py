"""The report: one HTML file that needs nothing else, its tables beside it; figures as files."""

import re
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.analysis import words
from tactometry.analysis.findings import Outcome
from tactometry.analysis.group import cross_table
from tactometry.analysis.pipeline import Analysis
from tactometry.analysis.printing import print_pdf
from tactometry.analysis.ratings import Ratings
from tactometry.analysis.report_figures import NAMES, Figure, Place, figures_of
from tactometry.analysis.table_files import write_tables
from tactometry.analysis.together import Together
from tactometry.errors import DeviceFailed, InvalidParameter
from tactometry.safe_text import file_text


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
    check_report(path)
    folder = path.with_name(f"{path.stem}_tables")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        page = render(found)
        write_tables(found.tables, folder)
        path.write_text(page, encoding="utf-8")
    except OSError as failure:
        raise DeviceFailed(f"{failure.filename or path}: cannot be written ({failure.strerror})") from None
    if pdf:
        print_pdf(path)
    return replace(found, report=path, tables_folder=folder)


def check_report(path: Path) -> None:
    """Whether a report may have this name.

    Raises
    ------
    InvalidParameter
        If it does not end in ``.html``.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        raise InvalidParameter(f"--report: found {path.name!r}, expected a file name that ends in .html")


def write_figures(found: Analysis, folder: Path) -> Analysis:
    """Write every figure as SVG and PNG (300 dots per inch) and, beside them, the table that holds its numbers.

    Raises
    ------
    DeviceFailed
        If something cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for figure in figures_of(found):
            stem = file_text(figure.name)
            (folder / f"{stem}.svg").write_text(figure.drawing.svg, encoding="utf-8")
            (folder / f"{stem}.png").write_bytes(figure.drawing.png())
            write_tables({figure.name: figure.rows(found.tables[figure.table])}, folder)
    except OSError as failure:
        raise DeviceFailed(f"{failure.filename or folder}: cannot be written ({failure.strerror})") from None
    return replace(found, figures_folder=folder)


def render(found: Analysis) -> str:
    """The whole page; the same data give the same text."""
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string((files("tactometry.analysis") / "report.html").read_text("utf-8"))
    drawn = figures_of(found)
    svgs = {figure.name: _numbered(figure, n) for n, figure in enumerate(drawn)}
    tables = found.tables
    return template.render(
        analysis=found,
        title=_title(found),
        names=NAMES,
        places=Place,
        figures=drawn,
        svgs=svgs,
        outcomes=[(o, _grid(o.cross), _effects_grid(o), o.all_sentences(found.unit)) for o in found.outcomes],
        forms=[(form, _summary_grid(form), form.sentences()) for form in found.forms],
        loss=_grid(_cross(found, "loss")) if "loss" in tables else None,
        force=_grid(_cross(found, "force")) if "force" in tables else None,
        choices={name: _grid(tables[name]) for name in words.CHOICES if name in tables},
        excluded=_grid(tables["excluded"]) if "excluded" in tables else None,
        quality=_grid(tables["quality"]),
        goodness=_grid(tables["goodness"].rename(columns=GOODNESS_COLUMNS)) if "goodness" in tables else None,
        thresholds=_grid(_short_thresholds(found)) if "thresholds" in tables else None,
        together=[(each, _cross_grid(each, found), each.sentences(found.unit)) for each in found.together],
        shrunken={each.task: _grid(each.participants) for each in found.together},
        references=words.references(found.methods),
        notes=_notes(found),
    )


def _notes(found: Analysis) -> list[str]:
    """What a reader must know of the outcomes and questionnaires, each once."""
    notes = [note for outcome in found.outcomes for note in outcome.notes]
    return list(dict.fromkeys([*notes, *(note for form in found.forms for note in form.notes)]))


def _numbered(figure: Figure, n: int) -> str:
    """Element names are made unique in the page: a reference must not reach into another figure."""
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\1f{n}-", figure.drawing.svg)


def _title(found: Analysis) -> str:
    rows = found.trials.rows
    studies = sorted(set(rows["study"])) if "study" in rows.columns else []
    title = ", ".join(study for study in studies if study) or found.trials.path.stem
    return f"{title} (simulated)" if found.origin.is_simulated else title


def _cross(found: Analysis, name: str) -> pd.DataFrame:
    return cross_table(found.tables[name], found.trials.factors)


def _cross_grid(each: Together, found: Analysis) -> Grid | None:
    if each.fit is None:
        return None
    return _grid(cross_table(each.conditions, each.fit.factors))


def _summary_grid(form: Ratings) -> Grid:
    """Conditions down, dimensions across, each as mean with interval."""
    cross = form.cross()
    return Grid(tuple(cross.columns), tuple(cross.itertuples(index=False, name=None)))


GOODNESS_COLUMNS = {
    "n_tested": "functions", "n_flagged": "with p ≤ .01", "n_by_chance": "by chance", "meaning": "what a small p says",
}  # fmt: skip
EFFECT_COLUMNS = {
    "Source": "effect", "term": "effect", "SS": "SS", "ddof1": "df 1", "ddof2": "df 2", "df1": "df 1", "df2": "df 2",
    "F": "F", "eps_CM": "epsilon", "p_CM_corr": "p", "p": "p", "p_permutation": "p", "np2": "partial eta²",
    "ng2": "generalised eta²",
}  # fmt: skip
"""What the page shows of the primary analysis; the file has the rest."""


def _effects_grid(outcome: Outcome) -> Grid | None:
    if outcome.effects is None:
        return None
    effects = outcome.effects[outcome.effects["F"].notna()]
    kept = [name for name in EFFECT_COLUMNS if name in effects.columns]
    return _grid(effects[kept].rename(columns=EFFECT_COLUMNS))


def _short_thresholds(found: Analysis) -> pd.DataFrame:
    table = found.tables["thresholds"]
    wanted = ["participant", *found.trials.factors, "threshold", "interval_low", "interval_high", "jnd", "jnd_low"]
    wanted += ["jnd_high", "width", "guess_rate", "lapse_rate", "n_trials", "n_catch", "status", "misfit"]
    return table[[name for name in wanted if name in table.columns]]


def _grid(table: pd.DataFrame) -> Grid:
    rows = tuple(tuple(_cell(value) for value in row) for row in table.itertuples(index=False, name=None))
    return Grid(tuple(str(name) for name in table.columns), rows)


def _cell(value: object) -> str:
    if value is None or value is pd.NA or (isinstance(value, float) and np.isnan(value)):
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
