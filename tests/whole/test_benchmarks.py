"""Benchmarks can be imported, and their page lists results, failures and misses."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from benchmark_modules import benchmark_module

from tactometry.experiments.harness import MeasuredItem

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
IMPORT = "import runpy, sys; runpy.run_path(sys.argv[1], run_name='imported')"


@pytest.mark.slow
@pytest.mark.parametrize("benchmark", sorted(path.name for path in BENCHMARKS.glob("*.py")))
def test_benchmark_can_be_imported(benchmark: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", IMPORT, benchmark], cwd=BENCHMARKS, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_mutation_run_removes_every_check_of_limits() -> None:
    mutation = benchmark_module("limits_mutation")
    source = (mutation.ROOT / "tactometry" / "safety" / "limits.py").read_text("utf-8")
    removed = [what for what, _ in mutation.mutants(source) if re.search(r": _check\(.* -> pass$", what)]
    assert len(removed) == len(re.findall(r"^ +_check\(", source, re.M)) > 5


table = benchmark_module("table")
SELECTED = [name for name in table.programs() if name not in table.ELSEWHERE]
TELLS = """\
import sys
from tactometry.experiments.harness import tell

if __name__ == "__main__":
    tell("ours over theirs", [1.0, 2.0, 9.0], at_most=1.5)
    tell("theirs", 3.0, "ms")
    sys.exit({status})
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Write two benchmarks; one fails after its results."""
    (tmp_path / "whole.py").write_text(TELLS.format(status=0), "utf-8")
    (tmp_path / "torn.py").write_text(TELLS.format(status="'no display'"), "utf-8")
    return tmp_path


@pytest.mark.parametrize("name", SELECTED)
def test_benchmark_prints_results_and_names_its_code(name: str) -> None:
    program = BENCHMARKS / f"{name}.py"
    assert "tell(" in program.read_text("utf-8")
    assert len(table.sources_of(program)) > 1


def test_page_is_that_of_the_kept_results() -> None:
    kept = table.read(BENCHMARKS / "results.json")
    assert kept
    assert (BENCHMARKS / "README.md").read_text("utf-8") == table.page(kept, table.programs())
    others = [page for text in table.ELSEWHERE.values() for page in text.split(" and ")]
    assert all((BENCHMARKS.parent / page).is_file() for page in others)


@pytest.mark.parametrize(
    ("values", "limits", "holds"),
    [
        ((1.0, 3.0, 9.0), {"at_most": 3.0}, True),
        ((1.0, 3.1, 9.0), {"at_most": 3.0}, False),
        ((5.0,), {"at_least": 4.0, "at_most": 6.0}, True),
        ((5.0,), {"at_least": 5.1}, False),
        ((float("nan"),), {"at_least": 0.0}, False),
        ((5.0,), {}, None),
    ],
)
def test_median_is_compared_with_the_required_value(
    values: tuple[float, ...], limits: dict[str, float], holds: bool | None
) -> None:
    assert MeasuredItem("a", values, **limits).holds is holds


MISSED = "| ours over theirs | 2 x | 1 to 9 | at most 1.5 x: **MISSED** |"


def test_page_lists_misses_and_failures_with_earlier_results(folder: Path) -> None:
    assert "## torn\n\nNot run yet." in table.page({}, table.programs(folder), folder)
    table.renew([], 2, folder)
    page = (folder / "README.md").read_text("utf-8")
    assert "0 of 1 required values are reached, 1 missed" in page
    assert MISSED in page
    failed = page.partition("## torn")[2]
    assert re.search(r"\*\*FAILED\*\* \(.*exit status 1: no display\); there is no previous run", failed)
    (folder / "whole.py").write_text(TELLS.format(status=3), "utf-8")
    table.renew(["whole"], 1, folder)
    section = (folder / "README.md").read_text("utf-8").partition("## whole")[2]
    assert MISSED in section
    assert re.search(r"\*\*FAILED\*\* .* the rows are from the previous run", section)


@pytest.mark.parametrize(("value", "is_missed"), [(2.0, True), (1.0, False)])
def test_known_reason_follows_only_a_miss(folder: Path, monkeypatch, value: float, is_missed: bool) -> None:
    monkeypatch.setitem(table.WHY_MISSED, "whole", "theirs became quicker")
    outcome = table.Outcome((MeasuredItem("ours over theirs", (value,), at_most=1.5),), machine="one")
    page = table.page({"whole": outcome}, table.programs(folder), folder)
    assert ("Missed: theirs became quicker." in page) is is_missed


def test_renewed_benchmark_leaves_the_others(folder: Path) -> None:
    before = table.Outcome((MeasuredItem("older", (1.0,)),), "2026-01-02", 0.5, "a machine", 1, 2.0)
    table.write({"torn": before}, folder)
    table.renew(["whole"], 1, folder)
    assert json.loads((folder / "results.json").read_text("utf-8"))["torn"]["date"] == "2026-01-02"
    section = (folder / "README.md").read_text().partition("## torn")[2]
    assert "2026-01-02, *code changed since*, runs: 1, load 0.5, machine 1." in section
    assert "| older | 1 x |  |  |" in section


def test_page_marks_rows_older_than_their_code(folder: Path) -> None:
    table.renew(["whole"], 1, folder)
    sections = []
    for _ in range(2):
        sections.append((folder / "README.md").read_text("utf-8").partition("## whole")[2])
        with (folder / "whole.py").open("a", encoding="utf-8") as program:
            program.write("# changed\n")
        table.write(table.read(folder / "results.json"), folder)
    assert ["*code changed since*" in section for section in sections] == [False, True]


def test_changed_neighbour_of_a_measured_module_changes_digest(tmp_path: Path) -> None:
    package = tmp_path / "tactometry" / "fits"
    package.mkdir(parents=True)
    for name in ("fits/fitting.py", "fits/starts.py", "psychometric.py", "x.py"):
        (package.parent / name).write_text("", "utf-8")
    program = tmp_path / "speed.py"
    program.write_text("from tactometry.fits.fitting import fit\nfrom tactometry.psychometric import SHAPES\n", "utf-8")
    names = [path.name for path in table.sources_of(program, tmp_path)]
    assert sorted(names) == ["fitting.py", "psychometric.py", "speed.py", "starts.py"]
    before = table.digest(program, tmp_path)
    (package / "starts.py").write_text("RATES = 7\n", "utf-8")
    assert table.digest(program, tmp_path) != before


@pytest.mark.parametrize(
    ("code", "reason"),
    [("pass", "ended without a result"), ("import time\n\ntime.sleep(60)", "took more than 2 s")],
    ids=["no result", "too long"],
)
def test_benchmark_without_results_has_failed(folder: Path, code: str, reason: str) -> None:
    (folder / "whole.py").write_text(f"{code}\n", "utf-8")
    assert table.once(folder / "whole.py", longest_s=60 if code == "pass" else 2) == ([], reason)
