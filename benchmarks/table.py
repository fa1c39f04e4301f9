"""Run benchmarks, and write the page of results, benchmarks/README.md: `python benchmarks/table.py [NAME ...]`.

Without a name, all benchmarks run. Results are stored in `results.json` with their dates. Each benchmark runs `--runs`
times in a separate process on one thread. The median of all repeats is compared with the required value. A failed
benchmark keeps the rows of its last successful run. `--page` only writes the page.
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

from tactometry.experiments import harness
from tactometry.experiments.harness import ROWS, MeasuredItem

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent
RESULTS, PAGE = "results.json", "README.md"
LONGEST_S = 3600.0
ELSEWHERE = {
    "accuracy_peers": "docs/explanation/cost.md",
    "bias_study": "docs/reference/analysis.md and docs/explanation/statistics.md",
    "install_size": "docs/how_to/install.md",
}
"""Benchmarks that run only when named, and the pages with their results."""
MEASURED_BY_COMMAND = {
    "cold_start": ("tactometry.cli", "tactometry.analysis.pipeline"),
    "limits_mutation": ("tactometry.safety.limits",),
    "time_to_zero": ("tactometry.devices.outputs", "tactometry.rigs"),
    "watch": ("tactometry.experiments.watch",),
}
"""Modules that a benchmark measures but does not import."""
OLDER = "code changed since"
WHY_MISSED = {
    "electrovibration": "for a step, LSODA requires 0.8 ms and Tactometry 0.02 ms. When the goal was set, these were "
    "1.6 and 0.014 ms (114 x). Other inputs are 100 to 600 times as fast",
    "filtered_peaks": "square waves, white noise or random bits in 8 channels at 192 kHz require four points per "
    "sample in every block, for voltage and current. Tones, carriers and signals far below the limits require few",
    "procedures": "with unknown slope and lapse rate, the bound of the error is 0.186 and 0.105 SD after 160 trials. "
    "No placement reaches the error of QUEST+ in fewer than 59 %, 46 % (wide), 53 % and 52 % (wide) of the trials",
    "time_reversal_products": "29.4 and 30.0 x in two runs, which is at the goal. It is 1.67 times as fast as the "
    "plain product at the peak rate of BLAS",
}
HEAD = f"""\
# Benchmarks

Required and measured ratios and times. `make bench` runs all of them (hours) and writes this page; `make bench
ARGS="watch traces"` runs two, `make bench ARGS=--page` only writes the page. The median is compared with the required
value. The spread is the range over repeats and runs. Ratios compare with another program that takes turns in the same
run. Times are processor times unless stated otherwise. Limits in seconds apply to a quiet machine. The load is the
largest number of processes that waited for a core. *{OLDER}* means that the measured packages
changed after the run, or were not recorded.

"""


@dataclass(frozen=True)
class Outcome:
    """Last successful run of a benchmark, failure of a later run, and digest of the measured code."""

    rows: tuple[MeasuredItem, ...] = ()
    date: str = ""
    load: float = 0.0
    machine: str = ""
    n_runs: int = 0
    took_s: float = 0.0
    failed: str = ""
    sources: str = ""


def programs(folder: Path = FOLDER) -> list[str]:
    """Return the names of the benchmarks, without shared modules."""
    result = (path for path in folder.glob("*.py") if path.name != Path(__file__).name)
    return sorted(path.stem for path in result if '__name__ == "__main__"' in path.read_text(encoding="utf-8"))


def sources_of(program: Path, root: Path = ROOT) -> list[Path]:
    """Return the files of a benchmark and of the code it measures.

    The measured code consists of the imported modules, each with the other modules of its package.

    For a module directly in `tactometry`, only this module is included.
    """
    tree = ast.parse(program.read_text(encoding="utf-8"))
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
    result = {program}
    for name in (*imported - {harness.__name__}, *MEASURED_BY_COMMAND.get(program.stem, ())):
        place = root.joinpath(*name.split("."))
        if name.split(".")[0] != "tactometry" or place == root / "tactometry":
            continue
        folder = place if place.is_dir() else place.parent
        result.update([place.with_suffix(".py")] if folder == root / "tactometry" else folder.glob("*.py"))
    return sorted(path for path in result if path.is_file())


def digest(program: Path, root: Path = ROOT) -> str:
    """Return the digest of the files of `sources_of`."""
    content = [path.name.encode() + b"\0" + path.read_bytes() for path in sources_of(program, root)]
    return sha256(b"\0".join(content)).hexdigest()[:16]


def once(program: Path, longest_s: float = LONGEST_S) -> tuple[list[MeasuredItem], str]:
    """Run a benchmark, and return its results and the reason of a failure (or an empty text)."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows"
        rows.touch()
        env = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ, ROWS: str(rows)}
        options = {"cwd": folder, "env": env, "timeout": longest_s, "stderr": subprocess.PIPE, "text": True}
        try:
            ended = subprocess.run([sys.executable, program], check=False, **options)
            message = (ended.stderr.strip().splitlines() or ["without a word"])[-1]
            failed = f"exit status {ended.returncode}: {message:.200}" if ended.returncode else ""
        except subprocess.TimeoutExpired:
            failed = f"took more than {longest_s:g} s"
        result = [measured(json.loads(line)) for line in rows.read_text(encoding="utf-8").splitlines()]
    return result, failed or ("" if result else "ended without a result")


def measured(kept: Mapping[str, object]) -> MeasuredItem:
    return MeasuredItem(**{**kept, "values": tuple(kept["values"])})  # type: ignore[arg-type]


def pooled(rows: Iterable[MeasuredItem]) -> tuple[MeasuredItem, ...]:
    """Join the results of several runs that have the same name."""
    by_name: dict[str, MeasuredItem] = {}
    for row in rows:
        before = by_name.get(row.what)
        by_name[row.what] = row if before is None else replace(row, values=(*before.values, *row.values))
    return tuple(by_name.values())


def run(program: Path, n_runs: int, before: Outcome) -> Outcome:
    """Run a benchmark several times. After a failure, the rows of `before` are kept."""
    began_s, load, sources = perf_counter(), 0.0, digest(program)
    today = datetime.now(UTC).date().isoformat()
    rows: list[MeasuredItem] = []
    for _ in range(n_runs):
        result, failed = once(program)
        rows, load = [*rows, *result], max(load, os.getloadavg()[0])
        if failed:
            return replace(before, failed=f"{today}, load {load:.1f}: {failed}")
    took_s = round(perf_counter() - began_s, 1)
    return Outcome(pooled(rows), today, round(load, 1), machine(), n_runs, took_s, sources=sources)


def machine() -> str:
    """Return processor, cores, system and versions in one line."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    processor = next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.processor())
    return f"{processor}, {os.cpu_count()} cores, {platform.system()}; {harness.machine()}"


def page(outcomes: Mapping[str, Outcome], names: Sequence[str], folder: Path = FOLDER) -> str:
    """Return the page, with a table for each benchmark."""
    known = {name: outcomes.get(name, Outcome()) for name in names}
    machines = list(dict.fromkeys(each.machine for each in known.values() if each.rows))
    verdicts = [row.holds for outcome in known.values() for row in outcome.rows]
    n_required = len(verdicts) - verdicts.count(None)
    lines = [f"{verdicts.count(True)} of {n_required} required values are reached, {verdicts.count(False)} missed.", ""]
    lines += [f"- Machine {n}: {each}" for n, each in enumerate(machines, 1)]
    lines += [f"- `{name}.py` runs only when named; its results are in {where}." for name, where in ELSEWHERE.items()]
    for name, outcome in known.items():
        if name not in ELSEWHERE:
            is_older = outcome.sources != digest(folder / f"{name}.py")
            lines += ["", f"## {name}", "", *_section(name, outcome, machines, is_older=is_older)]
    return HEAD + "\n".join(lines) + "\n"


def _section(name: str, outcome: Outcome, machines: Sequence[str], *, is_older: bool) -> Iterator[str]:
    if outcome.failed:
        kept = "the rows are from the previous run" if outcome.rows else "there is no previous run"
        yield f"**FAILED** ({outcome.failed}); {kept}.\n"
    if not outcome.rows:
        yield "Not run yet."
        return
    older = f", *{OLDER}*" if is_older else ""
    place = machines.index(outcome.machine) + 1
    yield f"{outcome.date}{older}, runs: {outcome.n_runs}, load {outcome.load:.1f}, machine {place}.\n"
    rows = []
    for row in outcome.rows:
        verdict = {None: "", True: ": reached", False: ": **MISSED**"}[row.holds]
        rows.append((row.what, row.in_unit(row.median), row.spread, f"{row.limits}{verdict}"))
    yield harness.table(("measured", "median", "spread", "required"), rows)
    if name in WHY_MISSED and any(row.holds is False for row in outcome.rows):
        yield f"\nMissed: {WHY_MISSED[name]}."


def read(path: Path) -> dict[str, Outcome]:
    """Read the stored results."""
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return {
        name: Outcome(**{**each, "rows": tuple(measured(row) for row in each["rows"])}) for name, each in kept.items()
    }


def write(outcomes: Mapping[str, Outcome], folder: Path) -> None:
    """Write the results and the page."""
    kept = {name: asdict(outcome) for name, outcome in sorted(outcomes.items())}
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(each)}" for name, each in kept.items())
    (folder / RESULTS).write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    (folder / PAGE).write_text(page(outcomes, programs(folder), folder), encoding="utf-8")


def renew(names: Sequence[str], n_runs: int, folder: Path = FOLDER) -> None:
    """Run some benchmarks, or all, and store each result as it is completed."""
    for name in names or [name for name in programs(folder) if name not in ELSEWHERE]:
        print(f"== {name}", flush=True)
        outcomes = read(folder / RESULTS)
        outcome = run(folder / f"{name}.py", n_runs, outcomes.get(name, Outcome()))
        print(outcome.failed and f"{name}: {outcome.failed}", flush=True)
        write({**outcomes, name: outcome}, folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(programs())}")
    parser.add_argument("--runs", type=int, default=3, help="runs of each")
    parser.add_argument("--page", action="store_true", help="run nothing")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in programs()]
    if unknown:
        parser.error(f"found no benchmark {unknown[0]!r}, expected one of {', '.join(programs())}")
    if arguments.page:
        write(read(FOLDER / RESULTS), FOLDER)
    else:
        renew(arguments.names, arguments.runs)


if __name__ == "__main__":
    main()
