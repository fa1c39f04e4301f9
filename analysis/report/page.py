"""The report: one HTML file that needs nothing else, its tables beside it; figures as files."""

import re
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

from tactometry.errors import DeviceFailed, InvalidParameter, counted
from tactometry.files.safe_text import file_text

from ..result import Analysis
from ..wording.labels import in_words, split_unit
from .kinds import KINDS
from .methods import references
from .pdf import print_pdf
from .section import Figure, Section
from .table_files import write_tables


def write_report(analysis: Analysis, path: Path, *, pdf: bool = False) -> Analysis:
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
        page = render(analysis)
        write_tables(analysis.tables, folder)
        path.write_text(page, encoding="utf-8")
    except OSError as failure:
        raise DeviceFailed(f"{failure.filename or path}: cannot be written ({failure.strerror})") from None
    if pdf:
        print_pdf(path)
    return replace(analysis, report=path, tables_folder=folder)


def check_report(path: Path) -> None:
    """Whether a report may have this name.

    Raises
    ------
    InvalidParameter
        If it does not end in ``.html``.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        raise InvalidParameter(f"--report: found {path.name!r}, expected a file name that ends in .html")


def write_figures(analysis: Analysis, folder: Path) -> Analysis:
    """Write every figure as SVG and PNG (300 dots per inch) and, beside them, the table that holds its numbers.

    Raises
    ------
    DeviceFailed
        If something cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for figure in figures_of(analysis):
            stem = file_text(figure.name)
            (folder / f"{stem}.svg").write_text(figure.drawing.svg, encoding="utf-8")
            (folder / f"{stem}.png").write_bytes(figure.drawing.png())
            write_tables({figure.name: figure.rows(analysis.tables[figure.table])}, folder)
    except OSError as failure:
        raise DeviceFailed(f"{failure.filename or folder}: cannot be written ({failure.strerror})") from None
    return replace(analysis, figures_folder=folder)


def render(analysis: Analysis) -> str:
    """The whole page; the same data give the same text."""
    from jinja2 import Environment, StrictUndefined

    factors = analysis.factors
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"words": lambda text: in_words(text, factors), "unbroken": unbroken}
    template = environment.from_string((files(__package__) / "page.html").read_text("utf-8"))
    sections = sections_of(analysis)
    drawn = [figure for section in sections for figure in section.figures()]
    return template.render(
        analysis=analysis,
        title=title_of(analysis),
        svgs={figure.name: _numbered(figure, n) for n, figure in enumerate(drawn)},
        data=data_line(analysis),
        warnings=[text for text in analysis.warnings if f"{text}." != analysis.origin.line] + _notes(analysis),
        sections=sections,
        references=references(analysis.methods),
    )


def sections_of(analysis: Analysis) -> list[Section]:
    """All sections between warnings and methods, with their figures drawn."""
    return [section for kind in KINDS for section in kind.sections(analysis)]


def figures_of(analysis: Analysis) -> list[Figure]:
    """Every figure of the report, in order."""
    return [figure for section in sections_of(analysis) for figure in section.figures()]


def data_line(analysis: Analysis) -> str:
    """What was read: rows, participants and files, factors and the unit of the levels."""
    rows, words_of = analysis.trials.rows, [split_unit(name)[0] for name in analysis.factors]
    n_participants = len(analysis.tables["quality"])
    names = ", ".join(sorted(set(rows["study"]) - {""})) if "study" in rows.columns else ""
    parts = [f"{'study ' + names + ': ' if names else ''}{counted(n_participants, 'participant')}"]
    parts.append(f"{counted(len(rows), 'row')} in {counted(analysis.trials.n_files, 'file')}")
    told = [", ".join(parts), f"factors: {', '.join(words_of) or 'none'}"]
    told += [f"levels in {analysis.unit}"] if analysis.unit else []
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


def _notes(analysis: Analysis) -> list[str]:
    """What a reader must know of the outcomes and questionnaires, each once."""
    notes = [note for outcome in analysis.outcomes for note in outcome.notes]
    return list(dict.fromkeys([*notes, *(note for form in analysis.forms for note in form.notes)]))


def _numbered(figure: Figure, n: int) -> str:
    """Element names are made unique in the page: a reference must not reach into another figure."""
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\1f{n}-", figure.drawing.svg)


def title_of(analysis: Analysis) -> str:
    """The title of the study, else its name, else that of the file."""
    rows = analysis.trials.rows
    studies = sorted(set(rows["study"])) if "study" in rows.columns else []
    title = analysis.study.title or ", ".join(study for study in studies if study) or analysis.trials.path.stem
    return f"{title} (simulated)" if analysis.origin.is_simulated else title
