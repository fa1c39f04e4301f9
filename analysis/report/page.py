"""The report: one HTML file that needs nothing else, its tables beside it; figures as files."""

import re
from collections.abc import Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pandas as pd

from tactometry.errors import DeviceFailed, InvalidParameter, counted
from tactometry.files.safe_text import file_text

from ..outcomes.findings import Outcome
from ..outcomes.hierarchical_outcome import HierarchicalOutcome
from ..outcomes.ratings import Ratings
from ..result import Analysis
from ..tasks.kinds import RESULTS
from ..wording.cross_table import cross_table
from ..wording.decibels import as_amplitudes, is_decibel
from ..wording.labels import in_words, split_unit
from ..wording.numbers import p_text
from . import methods
from .captions import means_sentence
from .choice_text import choice_table
from .figure_list import NAMES, Figure, Place, figures_of
from .grid import TextGrid, grid
from .pdf import print_pdf
from .sentences import form_sentences, hierarchical_sentences, outcome_sentences
from .table_files import write_tables


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

    factors = found.trials.factors
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"words": lambda text: in_words(text, factors), "unbroken": unbroken}
    template = environment.from_string((files(__package__) / "page.html").read_text("utf-8"))
    drawn = figures_of(found)
    return template.render(
        analysis=found,
        title=title_of(found),
        names=NAMES,
        places=Place,
        figures=drawn,
        svgs={figure.name: _numbered(figure, n) for n, figure in enumerate(drawn)},
        data=data_line(found),
        warnings=[text for text in found.warnings if f"{text}." != found.origin.line] + _notes(found),
        outcomes=[_section(outcome, found) for outcome in found.outcomes],
        forms=[(form, means_sentence(form.summary), _summary_grid(form), form_sentences(form)) for form in found.forms],
        grids=_grids(found),
        choices={
            name: grid(choice_table(found.tables[name], name, found.trials, found.unit), factors)
            for name in RESULTS
            if name in found.tables
        },
        together=[
            (each, _cross_grid(each, found), hierarchical_sentences(each, found.unit)) for each in found.together
        ],
        shrunken={each.task: grid(each.participants, factors) for each in found.together},
        references=methods.references(found.methods),
    )


def _section(outcome: Outcome, found: Analysis) -> dict[str, object]:
    """What the page says of one dependent value."""
    sentences = outcome_sentences(outcome, found.unit)
    primary = sentences.pop(outcome.heading(), []) if outcome.primary is not None else []
    return {
        "outcome": outcome,
        "unit": outcome.unit(found.unit),
        "means": means_sentence(outcome.group),
        "cross": grid(outcome.cross, found.trials.factors),
        "amplitudes": amplitudes(outcome, found),
        "effects": _effects_grid(outcome, found.trials.factors),
        "primary": primary,
        "sentences": sentences,
    }


def amplitudes(outcome: Outcome, found: Analysis) -> tuple[str, TextGrid] | None:
    """The group table in the unit that decibels refer to, with this unit; None without decibels or a mean."""
    unit = outcome.unit(found.unit)
    if not is_decibel(unit) or outcome.group["mean"].isna().all():
        return None
    cross = cross_table(as_amplitudes(outcome.group), found.trials.factors)
    peak = " peak" * bool(found.study.procedure)  # the levels of our own stimuli are peaks
    return f"{unit.partition(' re 1 ')[2]}{peak}", grid(cross, found.trials.factors)


def _grids(found: Analysis) -> dict[str, TextGrid | None]:
    """The tables that stand alone; None where there is none."""
    tables, factors = dict(found.tables), found.trials.factors
    tables |= {name: cross_table(tables[name], factors) for name in ("loss", "force") if name in tables}
    if "thresholds" in tables:
        tables["thresholds"] = _short_thresholds(found)
    for name, heads in (("quality", QUALITY), ("goodness", GOODNESS_COLUMNS)):
        if name in tables:
            tables[name] = tables[name].rename(columns=heads)
    names = ("loss", "force", "excluded", "quality", "goodness", "thresholds")
    return {name: grid(tables[name], factors) if name in tables else None for name in names}


QUALITY = {
    "n_rows": "rows", "n_practice": "practice", "n_invalid": "invalid", "n_repeated": "asked again",
    "n_unanswered": "unanswered", "n_catch": "catch trials", "n_false_alarms": "false alarms",
    "false_alarm_rate": "rate of false alarms", "n_frames": "frames", "n_dropped_frames": "dropped frames",
}  # fmt: skip
"""Columns of the table of data quality, in words."""


def data_line(found: Analysis) -> str:
    """What was read: rows, participants and files, factors and the unit of the levels."""
    rows, words_of = found.trials.rows, [split_unit(name)[0] for name in found.trials.factors]
    n_participants = len(found.tables["quality"])
    names = ", ".join(sorted(set(rows["study"]) - {""})) if "study" in rows.columns else ""
    parts = [f"{'study ' + names + ': ' if names else ''}{counted(n_participants, 'participant')}"]
    parts.append(f"{counted(len(rows), 'row')} in {counted(found.trials.n_files, 'file')}")
    told = [", ".join(parts), f"factors: {', '.join(words_of) or 'none'}"]
    told += [f"levels in {found.unit}"] if found.unit else []
    line = "; ".join(told)
    return f"{line[0].upper()}{line[1:]}."


def unbroken(text: str) -> str:
    """A cell that breaks between a value, its interval or spread and its number, and not within them.

    >>> unbroken("0.29 [-0.78, 1.35] (n = 3)").replace(chr(160), "_").replace(chr(8209), "~")
    '0.29 [~0.78,_1.35] (n_=_3)'
    >>> unbroken("1.47 ± 0.03 N, 100 % in band").replace(chr(160), "_")
    '1.47 ±_0.03_N, 100_%_in_band'
    """
    held = re.sub(r"\[[^]]{,40}\]|\(n = [^)]{,40}\)|± \S+ N|\d+ % in band", lambda part: _joined(part[0]), text)
    return re.sub(r"-(?=\d)", "\u2011", held)


def _joined(text: str) -> str:
    return text.replace(" ", "\u00a0")


def _notes(found: Analysis) -> list[str]:
    """What a reader must know of the outcomes and questionnaires, each once."""
    notes = [note for outcome in found.outcomes for note in outcome.notes]
    return list(dict.fromkeys([*notes, *(note for form in found.forms for note in form.notes)]))


def _numbered(figure: Figure, n: int) -> str:
    """Element names are made unique in the page: a reference must not reach into another figure."""
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\1f{n}-", figure.drawing.svg)


def title_of(found: Analysis) -> str:
    """The title of the study, else its name, else that of the file."""
    rows = found.trials.rows
    studies = sorted(set(rows["study"])) if "study" in rows.columns else []
    title = found.study.title or ", ".join(study for study in studies if study) or found.trials.path.stem
    return f"{title} (simulated)" if found.origin.is_simulated else title


def _cross_grid(each: HierarchicalOutcome, found: Analysis) -> TextGrid | None:
    if each.fit is None:
        return None
    return grid(cross_table(each.conditions, each.fit.factors), found.trials.factors)


def _summary_grid(form: Ratings) -> TextGrid:
    """Conditions down, dimensions across, each as mean with interval."""
    cross = form.cross()
    return TextGrid(tuple(cross.columns), tuple(cross.itertuples(index=False, name=None)))


GOODNESS_COLUMNS = {
    "n_tested": "functions", "n_flagged": "with p ≤ .01", "n_by_chance": "by chance", "meaning": "what a small p says",
}  # fmt: skip
EFFECT_COLUMNS = {
    "Source": "effect", "term": "effect", "SS": "SS", "ddof1": "df 1", "ddof2": "df 2", "df1": "df 1", "df2": "df 2",
    "F": "F", "eps_CM": "epsilon", "p_CM_corr": "p (dfs times epsilon)", "p": "p", "p_permutation": "p",
    "np2": "partial eta²", "ng2": "generalised eta²",
}  # fmt: skip
"""What the page shows of the primary analysis; the file has the rest."""
P_COLUMNS = ("p_CM_corr", "p", "p_permutation")


def _effects_grid(outcome: Outcome, factors: Sequence[str]) -> TextGrid | None:
    if outcome.effects is None:
        return None
    effects = outcome.effects[outcome.effects["F"].notna()]
    shown = effects[[name for name in EFFECT_COLUMNS if name in effects.columns]].copy()
    for name in set(P_COLUMNS) & set(shown.columns):
        shown[name] = [p_text(p).removeprefix("p ").removeprefix("= ") for p in shown[name].astype(float)]
    for name in {"Source", "term"} & set(shown.columns):
        shown[name] = [in_words(source, factors) for source in shown[name]]
    return grid(shown.rename(columns=EFFECT_COLUMNS), ())


def _short_thresholds(found: Analysis) -> pd.DataFrame:
    table = found.tables["thresholds"]
    wanted = ["participant", *found.trials.factors, "threshold", "interval_low", "interval_high", "jnd", "jnd_low"]
    wanted += ["jnd_high", "width", "guess_rate", "lapse_rate", "n_trials", "n_catch", "status", "misfit"]
    wanted += [name for name in ("rule_estimate", "rule_sd", "rule_n") if table[name].notna().any()]
    return table[[name for name in wanted if name in table.columns]]
