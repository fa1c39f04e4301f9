"""Every benchmark, and benchmarks/README.md, the table of what they measured: `python benchmarks/table.py [NAME ...]`.

Without a name all are run; with names those are renewed, and the others keep their rows with their dates
(`results.json`). Each is run `--runs` times, as a program of its own on one thread; the median of all repeats is held
against what was asked. One that fails, or ends without a result, is told with its reason beside the rows of its last
run. `--page` alone writes the page anew from what is kept.
"""

import argparse
import ast
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from time import perf_counter

from measured import ROWS, Measured

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent
RESULTS, PAGE = "results.json", "README.md"
LONGEST_S = 3600.0
ELSEWHERE = {
    "census": "docs/reference/analysis.md, statuses",
    "census_groups": "docs/reference/analysis.md, coverage of the hierarchical intervals",
    "census_comparisons": "docs/reference/analysis.md, comparisons",
    "census_lapses": "docs/explanation/statistics.md, lapses",
    "install_size": "docs/how_to/install.md",
    "ladder_peers": "docs/explanation/cost.md",
}
"""They write what a page of the docs shows, and run by name alone."""
MEASURED_BY_COMMAND = {
    "cli_startup": ("tactometry.cli",),
    "cold_start": ("tactometry.cli", "tactometry.analysis.pipeline"),
    "limits_mutation": ("tactometry.safety.limits",),
    "time_to_zero": ("tactometry.devices.outputs", "tactometry.rigs"),
    "watch": ("tactometry.experiments.watch",),
}
"""Modules that a benchmark measures without importing them."""
OLDER = "code changed since"
WHY_MISSED = {
    "electrovibration_motion": "for a step LSODA takes 0.8 ms against our 0.02 ms; when the goal was set these were "
    "1.6 and 0.014 ms, 114 x. Other inputs are 100 to 600 times as quick",
    "filtered_peaks": "8 channels at 192 kHz of square waves, white noise or random bits need four points per sample "
    "in every block, for voltage and current; tones, carriers and signals far below the limits need few or none",
    "procedures": "the bound of the error, slope and lapse rate unknown, is 0.186 and 0.105 SD after 160 trials: what "
    "QUEST+ has then no placement reaches in fewer than 59 %, 46 % (wide), 53 % and 52 % (wide) of the trials",
    "time_reversal_products": "29.4 and 30.0 x in two runs, which is at the goal; the product is at 1.67 times the "
    "peak of the plain one",
}
"""Said below the table where a row of the benchmark is missed."""
HEAD = """\
# Benchmarks

Every ratio and time that was asked for, and what was reached. Written by `make bench`, which runs all of them (hours);
`make bench ARGS="watch traces"` renews two, `make bench ARGS=--page` writes this page from `results.json`. A median is
held against what was asked; the spread is that of repeats within and between runs. Ratios are to a peer of the same
run, in which both take turns; times are of the processor where nothing else is said. Limits in seconds are meant for a
quiet machine: a row's load says how quiet it was (processes that wanted a core, at most, while it ran). A row is marked
*code changed since* if the packages that it measures changed after its run, or if its run did not record them.

"""


@dataclass(frozen=True)
class Outcome:
    """The last run of a benchmark that gave results, and how a later one failed, if one did."""

    rows: tuple[Measured, ...] = ()
    date: str = ""
    load: float = 0.0
    machine: str = ""
    n_runs: int = 0
    took_s: float = 0.0
    failed: str = ""
    sources: str = ""
    """The digest of the code that it measured; empty in results of before it was recorded."""


def programs(folder: Path = FOLDER) -> list[str]:
    """The benchmarks, by name; not what they share."""
    own = Path(__file__).name
    found = (path for path in folder.glob("*.py") if path.name != own)
    return sorted(path.stem for path in found if '__name__ == "__main__"' in path.read_text(encoding="utf-8"))


def sources_of(program: Path, root: Path = ROOT) -> list[Path]:
    """Return a benchmark and the files it measures: each imported module with its package, without other packages.

    The packages count because a change is seldom in the module that is imported. A module directly below
    `tactometry` counts alone.
    """
    tree = ast.parse(program.read_text(encoding="utf-8"))
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
    found = {program}
    for name in (*imported, *MEASURED_BY_COMMAND.get(program.stem, ())):
        place = root.joinpath(*name.split("."))
        if name.split(".")[0] != "tactometry" or place == root / "tactometry":
            continue
        module = place.with_suffix(".py")
        folder = place if place.is_dir() else place.parent
        found.update([module] if folder == root / "tactometry" else folder.glob("*.py"))
    return sorted(path for path in found if path.is_file())


def digest(program: Path, root: Path = ROOT) -> str:
    """Return the digest of what `sources_of` returns."""
    content = [path.name.encode() + b"\0" + path.read_bytes() for path in sources_of(program, root)]
    return sha256(b"\0".join(content)).hexdigest()[:16]


def once(program: Path, longest_s: float = LONGEST_S) -> tuple[list[Measured], str]:
    """The results of one run, and why it failed; empty if it did not."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows"
        rows.touch()
        env = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ, ROWS: str(rows)}
        try:
            ended = subprocess.run([sys.executable, program], cwd=folder, env=env, timeout=longest_s, check=False,
                                   stderr=subprocess.PIPE, text=True)  # fmt: skip
            said = (ended.stderr.strip().splitlines() or ["without a word"])[-1]
            failed = f"exit status {ended.returncode}: {said:.200}" if ended.returncode else ""
        except subprocess.TimeoutExpired:
            failed = f"took more than {longest_s:g} s"
        found = [measured(json.loads(line)) for line in rows.read_text(encoding="utf-8").splitlines()]
    return found, failed or ("" if found else "ended without a result")


def measured(kept: Mapping[str, object]) -> Measured:
    return Measured(**{**kept, "values": tuple(kept["values"])})  # type: ignore[arg-type]


def pooled(rows: Iterable[Measured]) -> tuple[Measured, ...]:
    """Results of several runs, those of one name together."""
    by_name: dict[str, Measured] = {}
    for row in rows:
        before = by_name.get(row.what)
        by_name[row.what] = row if before is None else replace(row, values=(*before.values, *row.values))
    return tuple(by_name.values())


def run(program: Path, n_runs: int, before: Outcome) -> Outcome:
    """Run a benchmark some times; one that fails keeps what it measured `before`."""
    began_s, load, sources = perf_counter(), 0.0, digest(program)
    rows: list[Measured] = []
    for _ in range(n_runs):
        found, failed = once(program)
        rows, load = [*rows, *found], max(load, os.getloadavg()[0])
        if failed:
            return replace(before, failed=f"{_today()}, load {load:.1f}: {failed}")
    took_s = round(perf_counter() - began_s, 1)
    return Outcome(pooled(rows), _today(), round(load, 1), machine(), n_runs, took_s, sources=sources)


def _today() -> str:
    return datetime.now(UTC).date().isoformat()


def machine() -> str:
    """Processor, cores, system and versions."""
    from tactometry.experiments.cost.report import machine as versions

    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    processor = next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.processor())
    return f"{processor}, {os.cpu_count()} cores, {platform.system()}; Python {platform.python_version()}; {versions()}"


def page(outcomes: Mapping[str, Outcome], names: Sequence[str], folder: Path = FOLDER) -> str:
    """The page; benchmarks that were never run are named too, and rows older than the code they measure are marked."""
    machines = list(dict.fromkeys(each.machine for name in names if (each := outcomes.get(name)) and each.rows))
    known = {name: outcomes.get(name, Outcome()) for name in names}
    lines = [
        *_summary(known.values()),
        "",
        *_table(known, machines, _older(known, folder)),
        "",
        *_failures(known),
        *_reasons(known),
    ]
    lines += [f"- Machine {n}: {each}" for n, each in enumerate(machines, 1)]
    lines += [f"- `{name}.py` by name alone: what it finds stands in {where}." for name, where in ELSEWHERE.items()]
    return HEAD + "\n".join(lines) + "\n"


def _summary(outcomes: Iterable[Outcome]) -> Iterator[str]:
    verdicts = [row.holds for outcome in outcomes for row in outcome.rows]
    n_asked = len(verdicts) - verdicts.count(None)
    yield f"{verdicts.count(True)} of {n_asked} that were asked for are reached, {verdicts.count(False)} missed."


def _older(known: Mapping[str, Outcome], folder: Path) -> set[str]:
    """Return the benchmarks whose rows are of other code than there is."""
    return {name for name, outcome in known.items() if outcome.sources != digest(folder / f"{name}.py")}


def _table(known: Mapping[str, Outcome], machines: Sequence[str], older: set[str]) -> Iterator[str]:
    yield "| benchmark | what | asked | median | least to largest | repeats | | measured | load | machine |"
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for name, outcome in known.items():
        for row in outcome.rows:
            verdict = f"**{row.verdict}**" if row.holds is False else row.verdict
            date = f"{outcome.date}, *{OLDER}*" if name in older else outcome.date
            where = f"{date} | {outcome.load:.1f} | {machines.index(outcome.machine) + 1}"
            median = row.told(row.median)
            yield (
                f"| {name} | {row.what} | {row.asked} | {median} | {row.spread} | {len(row.values)} | {verdict} "
                f"| {where} |"
            )
        if not outcome.rows and not outcome.failed and name not in ELSEWHERE:
            yield f"| {name} | not run yet | | | | | | | | |"


def _failures(known: Mapping[str, Outcome]) -> Iterator[str]:
    for name, outcome in known.items():
        if outcome.failed:
            kept = "its rows are of the run before" if outcome.rows else "there is no run before"
            yield f"- **{name} FAILED** ({outcome.failed}); {kept}."


def _reasons(known: Mapping[str, Outcome]) -> Iterator[str]:
    for name, outcome in known.items():
        if name in WHY_MISSED and any(row.holds is False for row in outcome.rows):
            yield f"- {name}, missed: {WHY_MISSED[name]}."


def read(path: Path) -> dict[str, Outcome]:
    """What is kept."""
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return {
        name: Outcome(**{**each, "rows": tuple(measured(row) for row in each["rows"])}) for name, each in kept.items()
    }


def write(outcomes: Mapping[str, Outcome], folder: Path) -> None:
    kept = {name: asdict(outcome) for name, outcome in sorted(outcomes.items())}
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(each)}" for name, each in kept.items())
    (folder / RESULTS).write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    (folder / PAGE).write_text(page(outcomes, programs(folder), folder), encoding="utf-8")


def renew(names: Sequence[str], n_runs: int, folder: Path = FOLDER) -> None:
    """Run the benchmarks of these names, all where there is none; each is kept as it ends."""
    for name in names or [name for name in programs(folder) if name not in ELSEWHERE]:
        print(f"== {name}", flush=True)
        outcomes = read(folder / RESULTS)
        outcome = run(folder / f"{name}.py", n_runs, outcomes.get(name, Outcome()))
        print(outcome.failed and f"{name}: {outcome.failed}", flush=True)
        write({**outcomes, name: outcome}, folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(programs())}")
    parser.add_argument("--runs", type=int, default=3, help="how often each is run")
    parser.add_argument("--page", action="store_true", help="run nothing")
    said = parser.parse_args()
    unknown = [name for name in said.names if name not in programs()]
    if unknown:
        parser.error(f"found no benchmark {unknown[0]!r}, expected one of {', '.join(programs())}")
    if said.page:
        write(read(FOLDER / RESULTS), FOLDER)
    else:
        renew(said.names, said.runs)


if __name__ == "__main__":
    main()
