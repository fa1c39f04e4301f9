"""Every benchmark finds what it measures, and the table tells what they measured, failures and misses with it.

No test runs one whole, so that a move could leave one behind unseen."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from benchmark_modules import benchmark_module

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
IMPORT = "import runpy, sys; runpy.run_path(sys.argv[1], run_name='imported')"


@pytest.mark.slow
@pytest.mark.parametrize("benchmark", sorted(path.name for path in BENCHMARKS.glob("*.py")))
def test_a_benchmark_is_imported(benchmark: str) -> None:
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
measured = sys.modules["measured"]
TELLS = """\
import sys
from measured import tell

if __name__ == "__main__":
    tell("ours over theirs", [1.0, 2.0, 9.0], at_most=1.5)
    tell("theirs", 3.0, "ms")
    sys.exit({status})
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of two benchmarks: one that gives results, and one that fails behind its first."""
    (tmp_path / "measured.py").write_text((BENCHMARKS / "measured.py").read_text("utf-8"), "utf-8")
    (tmp_path / "whole.py").write_text(TELLS.format(status=0), "utf-8")
    (tmp_path / "torn.py").write_text(TELLS.format(status="'no display'"), "utf-8")
    return tmp_path


@pytest.mark.parametrize("name", [name for name in table.programs() if name not in table.ELSEWHERE])
def test_each_benchmark_tells_results(name: str) -> None:
    text = (BENCHMARKS / f"{name}.py").read_text("utf-8")
    assert re.search(r"\b(tell|row)\(", text)


def test_pages_that_hold_the_results_of_others_stand() -> None:
    assert all((BENCHMARKS.parent / page.partition(",")[0]).is_file() for page in table.ELSEWHERE.values())


def test_the_page_is_that_of_the_results_that_are_kept() -> None:
    kept = table.read(BENCHMARKS / "results.json")
    assert kept
    assert (BENCHMARKS / "README.md").read_text("utf-8") == table.page(kept, table.programs())


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
def test_the_median_is_held_against_what_was_asked(
    values: tuple[float, ...], limits: dict[str, float], holds: bool | None
) -> None:
    assert measured.Measured("a", values, **limits).holds is holds


def test_a_miss_and_a_failure_are_told_and_results_before_stay(folder: Path) -> None:
    table.renew([], 2, folder)
    page = (folder / "README.md").read_text("utf-8")
    assert "0 of 1 that were asked for are reached, 1 missed" in page
    assert "| whole | ours over theirs | at most 1.5 x | 2 x | 1 to 9 | 6 | **MISSED** |" in page
    assert re.search(r"\*\*torn FAILED\*\* \(.*exit status 1: no display\); there is no run before", page)
    (folder / "whole.py").write_text(TELLS.format(status=3), "utf-8")
    table.renew(["whole"], 1, folder)
    page = (folder / "README.md").read_text("utf-8")
    assert "| whole | ours over theirs | at most 1.5 x | 2 x | 1 to 9 | 6 | **MISSED** |" in page
    assert re.search(r"\*\*whole FAILED\*\* .* its rows are of the run before", page)


def test_explained_miss_has_a_reason(folder: Path, monkeypatch) -> None:
    monkeypatch.setitem(table.WHY_MISSED, "whole", "theirs became quicker")
    reason = "- whole, missed: theirs became quicker."
    for value, told in ((2.0, True), (1.0, False)):
        outcome = table.Outcome((measured.Measured("ours over theirs", (value,), at_most=1.5),), machine="one")
        assert (reason in table.page({"whole": outcome}, table.programs(folder), folder)) is told


def test_one_that_is_renewed_leaves_the_others_with_their_dates(folder: Path) -> None:
    before = table.Outcome((measured.Measured("older", (1.0,)),), "2026-01-02", 0.5, "a machine", 1, 2.0)
    table.write({"torn": before}, folder)
    table.renew(["whole"], 1, folder)
    kept = json.loads((folder / "results.json").read_text("utf-8"))
    assert kept["torn"]["date"] == "2026-01-02"
    assert "| torn | older | | 1 x | | 1 | | 2026-01-02, *code changed since* | 0.5 |" in re.sub(
        " +", " ", (folder / "README.md").read_text()
    )


def test_page_marks_rows_older_than_their_code(folder: Path) -> None:
    table.renew(["whole"], 1, folder)
    assert "changed since* |" not in (folder / "README.md").read_text("utf-8")
    with (folder / "whole.py").open("a", encoding="utf-8") as program:
        program.write("# changed\n")
    table.write(table.read(folder / "results.json"), folder)
    rows = [line for line in (folder / "README.md").read_text("utf-8").splitlines() if line.startswith("| whole")]
    assert len(rows) == 2
    assert all("*code changed since* |" in row for row in rows)


def test_changed_neighbour_of_a_measured_module_changes_digest(tmp_path: Path) -> None:
    package = tmp_path / "tactometry" / "fits"
    package.mkdir(parents=True)
    for file in (
        package / "fitting.py",
        package / "starts.py",
        package.parent / "psychometric.py",
        package.parent / "x.py",
    ):
        file.write_text("", "utf-8")
    program = tmp_path / "speed.py"
    program.write_text("from tactometry.fits.fitting import fit\nfrom tactometry.psychometric import SHAPES\n", "utf-8")
    names = [path.name for path in table.sources_of(program, tmp_path)]
    assert sorted(names) == ["fitting.py", "psychometric.py", "speed.py", "starts.py"]
    before = table.digest(program, tmp_path)
    (package / "starts.py").write_text("RATES = 7\n", "utf-8")
    assert table.digest(program, tmp_path) != before


@pytest.mark.parametrize("name", [name for name in table.programs() if name not in table.ELSEWHERE])
def test_each_benchmark_names_the_code_it_measures(name: str) -> None:
    assert len(table.sources_of(BENCHMARKS / f"{name}.py")) > 1


def test_one_that_says_nothing_has_failed(folder: Path) -> None:
    (folder / "whole.py").write_text('if __name__ == "__main__":\n    pass\n', "utf-8")
    assert table.once(folder / "whole.py") == ([], "ended without a result")


def test_one_that_takes_too_long_is_ended(folder: Path) -> None:
    (folder / "whole.py").write_text("import time\n\ntime.sleep(60)\n", "utf-8")
    assert table.once(folder / "whole.py", longest_s=0.2) == ([], "took more than 0.2 s")


def test_benchmark_never_run_is_listed(folder: Path) -> None:
    assert "| torn | not run yet |" in table.page({}, table.programs(folder), folder)
