"""The report as one HTML file with its tables as CSV, figures as files, and a PDF by a browser or WeasyPrint."""

import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Protocol

import pandas as pd

from tactometry.arguments.require import expect
from tactometry.errors import DeviceFailed, attempt, count_of
from tactometry.files.rows import LIST_OF_TABLES, file_text, spreadsheet_text

from ..reading.quality import tally_of
from ..result import Analysis
from ..wording import in_words, split_unit
from .kinds import KINDS
from .methods import references
from .section import Figure, Section
from .texts import environment

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
WEASYPRINT = "weasyprint"
PDF_TIMEOUT_S = 120.0
Drawn = tuple[str, bytes | None]
"""SVG text of a figure, and its PNG."""


class DrawEach(Protocol):
    """Function that draws each figure, here (`map`) or in other processes, in their order."""

    def __call__(self, draw: Callable[[Figure], Drawn], figures: Iterable[Figure], /) -> Iterable[Drawn]: ...


def write_report(
    analysis: Analysis,
    path: str | Path,
    *,
    pdf: bool = False,
    sections: Sequence[Section] | None = None,
    svgs: Mapping[str, str] | None = None,
) -> Analysis:
    """Write the report to `path`, its tables to the folder ``<stem>_tables``, and a PDF if requested.

    Sections and `svgs` of the figures by name are made unless they are given.

    Raises
    ------
    InvalidParameter
        If `path` does not end in ``.html``.
    DeviceFailed
        If something cannot be written or printed.
    """
    path = Path(path)
    check_report(path)
    folder = path.with_name(f"{path.stem}_tables")
    with attempt(path, "cannot be written, or its tables", "a place to write to"):
        folder.mkdir(parents=True, exist_ok=True)
        page = render(analysis, sections, svgs)
        _remove_earlier(folder)
        write_tables(analysis.tables, folder)
        names = "".join(f"{file_text(name)}.csv\n" for name in analysis.tables)
        (folder / LIST_OF_TABLES).write_text(names, encoding="utf-8")
        path.write_text(page, encoding="utf-8")
    if pdf:
        print_pdf(path)
    return replace(analysis, report=path, tables_folder=folder, pdf=path.with_suffix(".pdf") if pdf else None)


def _remove_earlier(folder: Path) -> None:
    """Remove the tables of an earlier report, which a file lists; other files stay."""
    listed = folder / LIST_OF_TABLES
    names = listed.read_text(encoding="utf-8", errors="replace").splitlines() if listed.exists() else []
    for name in names:
        if Path(name).name == name and name.endswith(".csv"):
            (folder / name).unlink(missing_ok=True)


def check_report(path: Path) -> None:
    """Refuse a report whose name does not end in ``.html``."""
    expect(path.suffix.lower() in (".html", ".htm"), "--report", repr(path.name), "a file name that ends in .html")


def write_figures(
    analysis: Analysis, folder: Path, sections: Sequence[Section] | None = None, spread: DrawEach = map
) -> dict[str, str]:
    """Write every figure as SVG and PNG (300 dots per inch) with the table of its numbers; return the SVG texts.

    `spread` distributes the drawing over processes.

    Raises
    ------
    DeviceFailed
        If something cannot be written.
    """
    with attempt(folder, "cannot be written", "a place to write to"):
        folder.mkdir(parents=True, exist_ok=True)
        svgs, figures = {}, figures_of(analysis, sections)
        for figure, (svg, png) in zip(figures, spread(partial(_drawn, with_png=True), figures), strict=True):
            assert png is not None
            stem = file_text(figure.name)
            (folder / f"{stem}.svg").write_text(svg, encoding="utf-8")
            (folder / f"{stem}.png").write_bytes(png)
            write_tables({figure.name: figure.rows(analysis.tables[figure.table])}, folder)
            svgs[figure.name] = svg
    return svgs


def draw_figures(figures: Sequence[Figure], spread: DrawEach = map) -> dict[str, str]:
    """Return the SVG text of each figure by name."""
    drawn = spread(partial(_drawn, with_png=False), figures)
    return {figure.name: svg for figure, (svg, _) in zip(figures, drawn, strict=True)}


def _drawn(figure: Figure, with_png: bool) -> Drawn:
    drawing = figure.draw()
    return drawing.svg, drawing.png() if with_png else None


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write each table as NAME.csv in the folder."""
    for name, table in tables.items():
        (folder / f"{file_text(name)}.csv").write_bytes(csv_bytes(table))


def csv_bytes(table: pd.DataFrame) -> bytes:
    """Format a table as CSV whose texts a spreadsheet does not evaluate.

    >>> csv_bytes(pd.DataFrame({"@pattern": ["=1+1", "P0"], "threshold": [-1.5, None]}))
    b"'@pattern,threshold\\n'=1+1,-1.5\\nP0,\\n"
    """
    cells = table.astype(object).where(table.notna(), None)
    return spreadsheet_text(([str(name) for name in table.columns], *cells.itertuples(index=False, name=None)))


def render(analysis: Analysis, sections: Sequence[Section] | None = None, svgs: Mapping[str, str] | None = None) -> str:
    """Return the whole page; the same data give the same text."""
    sections = sections_of(analysis) if sections is None else sections
    if svgs is None:
        svgs = draw_figures(figures_of(analysis, sections))
    # The first line of the page states already that participants were simulated.
    warnings = [text for text in analysis.warnings if f"{text}." != analysis.origin.line]
    return (
        environment(is_html=True)
        .get_template("page.html")
        .render(
            words=partial(in_words, factors=analysis.factors),
            nonbreaking=nonbreaking,
            analysis=analysis,
            title=title_of(analysis),
            svgs={name: _with_unique_names(svg, n) for n, (name, svg) in enumerate(svgs.items())},
            data=data_line(analysis),
            warnings=warnings + _notes(analysis),
            sections=sections,
            references=references(analysis.methods),
        )
    )


def sections_of(analysis: Analysis) -> list[Section]:
    """Return all sections between warnings and methods."""
    return [section for kind in KINDS for section in kind.sections(analysis)]


def figures_of(analysis: Analysis, sections: Sequence[Section] | None = None) -> list[Figure]:
    """Return every figure of the report, in order."""
    made = sections_of(analysis) if sections is None else sections
    return [figure for section in made for figure in section.figures()]


def data_line(analysis: Analysis) -> str:
    """Return participants, trials, files, factors and unit of the levels in one line."""
    trials, studies = analysis.trials, ", ".join(_studies(analysis))
    participants = count_of(len(analysis.tables["quality"]), "participant")
    read = f"{tally_of(trials)}, in {count_of(trials.n_files, 'file')}"
    factors = ", ".join(split_unit(name)[0] for name in trials.factors) or "none"
    levels = f"; levels in {analysis.unit}" if analysis.unit else ""
    line = f"{f'study {studies}: ' if studies else ''}{participants}, {read}; factors: {factors}{levels}."
    return line[0].upper() + line[1:]


def _studies(analysis: Analysis) -> list[str]:
    rows = analysis.trials.rows
    return sorted(set(rows["study"]) - {""}) if "study" in rows.columns else []


def nonbreaking(text: str) -> str:
    """Prevent line breaks within an interval, a spread or a number of participants.

    >>> nonbreaking("0.29 [-0.78, 1.35] (n = 3)").replace(chr(160), "_").replace(chr(8209), "~")
    '0.29 [~0.78,_1.35] (n_=_3)'
    >>> nonbreaking("1.47 ± 0.03 N, 100 % in band").replace(chr(160), "_")
    '1.47 ±_0.03_N, 100_%_in_band'
    """
    together = r"\[[^]]{,40}\]|\(n = [^)]{,40}\)|± \S+ N|\d+ % in band"
    joined = re.sub(together, lambda match: match[0].replace(" ", "\u00a0"), text)
    return re.sub(r"-(?=\d)", "\u2011", joined)


def _notes(analysis: Analysis) -> list[str]:
    notes = [note for outcome in analysis.outcomes for note in outcome.notes]
    # Each note once.
    return list(dict.fromkeys([*notes, *(note for form in analysis.forms for note in form.notes)]))


def _with_unique_names(svg: str, n: int) -> str:
    """Make element names unique in the page, as a reference must not reach into another figure."""
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\1f{n}-", svg)


def title_of(analysis: Analysis) -> str:
    """Return the title of the study, else its name, else that of the file."""
    title = analysis.study.title or ", ".join(_studies(analysis)) or analysis.trials.path.stem
    return f"{title} (simulated)" if analysis.origin.is_simulated else title


def print_pdf(path: Path) -> Path:
    """Print the page to a PDF in the same folder.

    Raises
    ------
    DeviceFailed
        If there is neither browser nor WeasyPrint, or it fails.
    """
    engine = next(filter(None, map(shutil.which, (*BROWSERS, WEASYPRINT))), None)
    if engine is None:
        raise DeviceFailed(
            f"--pdf: found neither a browser ({', '.join(BROWSERS)}) nor {WEASYPRINT}, expected one; print {path} by "
            "hand"
        )
    target = path.with_suffix(".pdf").resolve()
    target.unlink(missing_ok=True)  # an earlier file would hide a failure
    with tempfile.TemporaryDirectory() as profile:
        command = _command(engine, path, target, profile)
        try:
            done = subprocess.run(command, capture_output=True, timeout=PDF_TIMEOUT_S, check=False)
        except subprocess.TimeoutExpired:
            raise DeviceFailed(f"--pdf: {engine} did not end in {PDF_TIMEOUT_S:g} s; print {path} by hand") from None
    if done.returncode != 0 or not target.exists():
        raise DeviceFailed(f"--pdf: {engine} ended with status {done.returncode}; print {path} by hand")
    return target


def _command(engine: str, path: Path, target: Path, profile: str) -> list[str]:
    if Path(engine).name == WEASYPRINT:
        return [engine, str(path.resolve()), str(target)]
    return [
        engine,
        *("--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={profile}"),
        f"--print-to-pdf={target}",
        path.resolve().as_uri(),
    ]
