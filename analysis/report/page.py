"""Output of a report: HTML page, CSV tables, figure files and PDF."""

import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
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
"""SVG text of a figure, and its PNG (None if not requested)."""


class DrawEach(Protocol):
    """Function like `map` that draws figures, possibly in other processes."""

    def __call__(self, draw: Callable[[Figure], Drawn], figures: Iterable[Figure], /) -> Iterable[Drawn]: ...


def write_report(
    analysis: Analysis, path: str | Path, *, pdf: bool = False, svgs: Mapping[str, str] | None = None
) -> Analysis:
    """Write the report, its tables and, if requested, a PDF.

    The tables are written to the folder ``<stem>_tables``. `svgs` contains figures that are already drawn, by name.

    Raises
    ------
    InvalidParameter
        If `path` does not end in ``.html``.
    DeviceFailed
        If a file cannot be written or printed.
    """
    path = Path(path)
    check_report(path)
    folder = path.with_name(f"{path.stem}_tables")
    with attempt(path, "or its tables cannot be written", "a writable folder"):
        folder.mkdir(parents=True, exist_ok=True)
        page = render(analysis, svgs)
        _remove_earlier(folder)
        write_tables(analysis.tables, folder)
        names = "".join(f"{file_text(name)}.csv\n" for name in analysis.tables)
        (folder / LIST_OF_TABLES).write_text(names, encoding="utf-8")
        path.write_text(page, encoding="utf-8")
    if pdf:
        print_pdf(path)
    return replace(analysis, report=path, tables_folder=folder, pdf=path.with_suffix(".pdf") if pdf else None)


def _remove_earlier(folder: Path) -> None:
    """Remove the tables of an earlier report."""
    listed = folder / LIST_OF_TABLES
    names = listed.read_text(encoding="utf-8", errors="replace").splitlines() if listed.exists() else []
    for name in names:
        if Path(name).name == name and name.endswith(".csv"):
            (folder / name).unlink(missing_ok=True)


def check_report(path: Path) -> None:
    """Raise for a report whose name does not end in ``.html``."""
    expect(path.suffix.lower() in (".html", ".htm"), "--report", repr(path.name), "a file name that ends in .html")


def draw_figures(analysis: Analysis, spread: DrawEach = map, folder: Path | None = None) -> dict[str, str]:
    """Return the SVG text of each figure by name.

    With a `folder`, each figure is also written as SVG and PNG (300 dots per inch) with a table of its numbers.
    `spread` may draw figures in parallel.

    Raises `DeviceFailed` if a file cannot be written.
    """
    figures, svgs = figures_of(analysis), {}
    drawn = spread(partial(_drawn, with_png=folder is not None), figures)
    with nullcontext() if folder is None else attempt(folder, "cannot be written", "a writable folder"):
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        for figure, (svg, png) in zip(figures, drawn, strict=True):
            svgs[figure.name] = svg
            if folder is not None and png is not None:
                stem = file_text(figure.name)
                (folder / f"{stem}.svg").write_text(svg, encoding="utf-8")
                (folder / f"{stem}.png").write_bytes(png)
                write_tables({figure.name: figure.rows(analysis.tables[figure.table])}, folder)
    return svgs


def _drawn(figure: Figure, with_png: bool) -> Drawn:
    drawing = figure.draw()
    return drawing.svg, drawing.png() if with_png else None


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write each table to the folder as NAME.csv."""
    for name, table in tables.items():
        (folder / f"{file_text(name)}.csv").write_bytes(csv_bytes(table))


def csv_bytes(table: pd.DataFrame) -> bytes:
    """Format a table as CSV without cells that could run as formulas.

    >>> csv_bytes(pd.DataFrame({"@pattern": ["=1+1", "P0"], "threshold": [-1.5, None]}))
    b"'@pattern,threshold\\n'=1+1,-1.5\\nP0,\\n"
    """
    cells = table.astype(object).where(table.notna(), None)
    return spreadsheet_text(([str(name) for name in table.columns], *cells.itertuples(index=False, name=None)))


def render(analysis: Analysis, svgs: Mapping[str, str] | None = None) -> str:
    """Return the page as HTML; the same data yield the same text."""
    svgs = draw_figures(analysis) if svgs is None else svgs
    rows = analysis.trials.rows
    studies = sorted(set(rows["study"]) - {""}) if "study" in rows.columns else []
    # The first line of the page already contains the warning about simulated participants.
    warnings = [text for text in analysis.warnings if f"{text}." != analysis.origin.line]
    notes = [note for outcome in analysis.outcomes for note in outcome.notes]
    notes += [note for form in analysis.forms for note in form.notes]
    page = environment(is_html=True).get_template("page.html")
    return page.render(
        words=partial(in_words, factors=analysis.factors),
        nonbreaking=nonbreaking,
        analysis=analysis,
        title=analysis.study.title or ", ".join(studies) or analysis.trials.path.stem,
        svgs={name: _with_unique_names(svg, n) for n, (name, svg) in enumerate(svgs.items())},
        studies=studies,
        participants=count_of(len(analysis.tables["quality"]), "participant"),
        trials=tally_of(analysis.trials),
        files=count_of(analysis.trials.n_files, "file"),
        factors=[split_unit(name)[0] for name in analysis.factors],
        warnings=warnings + list(dict.fromkeys(notes)),
        sections=sections_of(analysis),
        references=references(analysis.methods),
    )


def sections_of(analysis: Analysis) -> list[Section]:
    """Return all sections between the warnings and the methods."""
    return [section for kind in KINDS for section in kind.sections(analysis)]


def figures_of(analysis: Analysis) -> list[Figure]:
    """Return every figure of the report, in order."""
    return [figure for section in sections_of(analysis) for figure in section.figures()]


def nonbreaking(text: str) -> str:
    """Prevent line breaks within an interval, a spread or a number.

    >>> nonbreaking("0.29 [-0.78, 1.35] (n = 3)").replace(chr(160), "_").replace(chr(8209), "~")
    '0.29 [~0.78,_1.35] (n_=_3)'
    >>> nonbreaking("1.47 ± 0.03 N, 100 % in band").replace(chr(160), "_")
    '1.47 ±_0.03_N, 100_%_in_band'
    """
    together = r"\[[^]]{,40}\]|\(n = [^)]{,40}\)|± \S+ N|\d+ % in band"
    joined = re.sub(together, lambda match: match[0].replace(" ", "\u00a0"), text)
    return re.sub(r"-(?=\d)", "\u2011", joined)


def _with_unique_names(svg: str, n: int) -> str:
    """Make the element names of a figure unique within the page."""
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\1f{n}-", svg)


def print_pdf(path: Path) -> Path:
    """Print the page to a PDF in the same folder.

    Raises `DeviceFailed` if neither a browser nor WeasyPrint is installed, or if it fails.
    """
    engine = next(filter(None, map(shutil.which, (*BROWSERS, WEASYPRINT))), None)
    if engine is None:
        raise DeviceFailed(
            f"--pdf: found neither a browser ({', '.join(BROWSERS)}) nor {WEASYPRINT}, expected one of them; print "
            f"{path} manually"
        )
    target = path.with_suffix(".pdf").resolve()
    target.unlink(missing_ok=True)  # otherwise an earlier file could hide a failure
    with tempfile.TemporaryDirectory() as profile:
        command = _command(engine, path, target, profile)
        try:
            done = subprocess.run(command, capture_output=True, timeout=PDF_TIMEOUT_S, check=False)
        except subprocess.TimeoutExpired:
            raise DeviceFailed(
                f"--pdf: {engine} did not finish within {PDF_TIMEOUT_S:g} s; print {path} manually"
            ) from None
    if done.returncode != 0 or not target.exists():
        raise DeviceFailed(f"--pdf: {engine} failed with status {done.returncode}; print {path} manually")
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
