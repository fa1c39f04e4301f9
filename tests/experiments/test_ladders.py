"""Laws of every ladder, and what `tactometry cost` makes of them."""

import csv
import json
import math
from dataclasses import asdict, replace
from functools import partial

import pytest
from command_line import status
from places import DOCS
from soak import SOAK

from tactometry.experiments.cost.figures import error_against_price, frontier
from tactometry.experiments.cost.measure import cheapest, climb
from tactometry.experiments.cost.page import digit
from tactometry.experiments.cost.peers import RECORD, peers_of, recorded_on
from tactometry.experiments.cost.problem import Problem, Reference, Rung
from tactometry.experiments.cost.report import answers, label, table
from tactometry.experiments.ladders import LADDERS, problem_of
from tactometry.experiments.ladders.cold import cold_s

PAGE = DOCS / "explanation" / "cost.md"
N_RUNGS = {} if SOAK else {"group-threshold": 3}
"""In the reduced form, of each contender."""


def reduced(problem: Problem) -> Problem:
    contenders = dict.fromkeys(rung.contender for rung in problem.rungs)
    groups = [[rung for rung in problem.rungs if rung.contender == name] for name in contenders]
    return replace(problem, rungs=tuple(rung for group in groups for rung in group[: N_RUNGS.get(problem.name)]))


DEAR = ("procedures", "group-threshold", "scene-hybrid-screen")
CLIMBED = [pytest.param(name, marks=pytest.mark.slow if name in DEAR else ()) for name in LADDERS]


@pytest.fixture(scope="module", params=CLIMBED)
def found(request):
    return climb(reduced(problem_of(request.param)), n_rounds=0)


# --- laws of every ladder


def test_the_error_falls_along_the_ladder_down_to_the_floor(found):
    for contender in found.contenders:
        errors = [max(point.error, found.floor) for point in found.of(contender)]
        assert len(errors) >= 2
        assert errors == sorted(errors, reverse=True)
        assert errors[0] > 1.5 * errors[-1]
    assert not any(point.unstable for point in found.points)


@pytest.mark.slow
def test_the_reference_agrees_with_an_independent_one(found):
    independent = found.problem.independent
    assert found.problem.error(independent.answer(), found.answer) <= found.floor + independent.uncertainty
    assert found.floor < found.points[0].error / 10
    assert independent.uncertainty < found.points[0].error / 2


def test_errors_are_the_same_in_every_run(found):
    rung, point = found.problem.rungs[0], found.points[0]
    assert found.problem.error(rung.run(), found.answer) == pytest.approx(point.error, rel=1e-6, abs=found.floor)


def test_the_table_fits_a_terminal_and_names_the_cheapest_rungs(found):
    lines = table(found).splitlines()
    assert max(map(len, lines[3:])) <= 100
    assert [line.split(":")[0] for line in lines[-4:]] == ["10.00%", "1.00%", "0.10%", "0.01%"]


def test_the_page_says_the_errors_of_this_run(found):
    stated = stated_errors(found.problem.name)
    for point in found.points:
        assert max(stated[label(point)], found.floor) == pytest.approx(max(point.error, found.floor), rel=0.1)
    assert (PAGE.with_suffix("") / f"{found.problem.name}.svg").stat().st_size > 10_000


def stated_errors(ladder: str) -> dict[str, float]:
    section = PAGE.read_text(encoding="utf-8").partition(f"\n## {ladder}\n")[2].partition("\n## ")[0]
    cells = [[cell.strip() for cell in line.split("|")[1:3]] for line in section.splitlines() if line.startswith("| ")]
    return {setting: math.inf if error == "unstable" else float(error) for setting, error in cells[1:]}


# --- the measuring itself, on a ladder whose answers are known


def halves(n: int) -> float:
    return 1 - 0.5**n if n < 30 else math.nan


def known(prices=(5.0, 3.0, 4.0, 9.0)) -> Problem:
    steps = (3, 7, 14, 40)
    rungs = tuple(Rung(f"n = {n}", partial(halves, n), price) for n, price in zip(steps, prices, strict=True))
    return Problem(
        "halves",
        Reference("one", lambda: 1.0, 1e-3),
        Reference("one", lambda: 1.0, 0.0),
        lambda a, b: abs(a - b),
        rungs,
        "coins",
        "known",
    )


def test_a_point_says_what_it_took():
    for point in climb(known(), n_rounds=2).points:
        assert min(point.price, point.first_s, point.median_s) > 0
        assert point.spread_s >= 0
        assert point.answer_bytes == 8


def test_cold_time_is_measured_in_a_new_process():
    """Machine code is loaded for each, a hundred times as long as a call; in one process, for the first alone."""
    problem = problem_of("time-integration")
    short = replace(problem, rungs=problem.rungs[:2])
    here = [point.first_s for point in climb(short, n_rounds=1).points]
    cold = [point.first_s for point in climb(short, n_rounds=1, cold_s=partial(cold_s, problem.name)).points]
    assert here[1] < 0.1 < min(cold)


def test_nonfinite_result_is_unstable_and_kept():
    points = climb(known(), n_rounds=1).points
    assert [point.unstable for point in points] == [False, False, False, True]
    assert points[-1].error == math.inf
    assert "unstable" in table(climb(known(), n_rounds=1))


def test_cheapest_setting_is_the_fastest_accurate_one():
    climbed = climb(known(), n_rounds=2)
    assert cheapest(climbed, 0.2).setting == "n = 7"
    assert cheapest(climbed, 2e-3).setting == "n = 14"
    assert answers(climbed)[1] == "1.00%: n = 7, price 3"


def test_errors_below_the_reference_floor_are_clipped():
    climbed = climb(known(), n_rounds=1)
    assert climbed.points[2].error < 1e-4
    assert cheapest(climbed, 1e-4) is None
    assert answers(climbed)[3] == "0.01%: no rung reaches it"


def test_the_frontier_leaves_out_what_is_beaten_in_both():
    assert [price for price, _ in frontier(climb(known(), n_rounds=1))] == [3.0, 4.0]


def test_one_more_digit_costs_the_factor_between_the_ends_of_the_frontier():
    climbed = climb(known((2.0, 3.0, 5.0, 9.0)), n_rounds=1)
    digits = math.log10(0.125 / 1e-3)
    assert digit(climbed) == f"x {2.5 ** (1 / digits):.2g}"
    assert digit(replace(climbed, points=climbed.points[:1])) == "nothing"


def test_the_figure_shows_every_rung_the_floor_and_the_unstable():
    figure = error_against_price(climb(known(), n_rounds=1))
    (axes,), (legend,) = figure.axes, figure.legends
    said = {text.get_text() for text in axes.texts}
    assert {"n = 3", "n = 7", "n = 14", "n = 40 (unstable)"} <= said
    assert {text.get_text() for text in legend.get_texts()} == {
        "tactometry",
        "cheapest",
        "reference's own error",
    }
    assert axes.get_xlabel() == "coins"
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_no_setting_is_written_over_another():
    climbed = climb(known((5.0, 5.1, 5.2, 5.3)), n_rounds=1)
    near = [replace(point, contender="other", price=point.price * 1.01) for point in climbed.points]
    (axes,) = error_against_price(climbed, near).axes
    boxes = [text.get_window_extent() for text in axes.texts if text.get_visible() and "n =" in text.get_text()]
    assert len(boxes) >= 6
    assert not any(box.count_overlaps(boxes[:n]) for n, box in enumerate(boxes))


# --- other programs


def test_every_recorded_peer_is_on_the_page():
    with RECORD.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = {row["contender"].split()[0].rstrip(",") for row in rows}
    assert {"finite", "scikit-fem", "solve_ivp", "psignifit", "questplus"} <= names
    for row in rows:
        assert f"{row['contender']}, {row['setting']}" in stated_errors(row["ladder"])


def test_a_peer_costs_what_it_would_on_this_machine(tmp_path):
    climbed = climb(known(), n_rounds=2)
    point = replace(climbed.points[0], contender="other", setting="loose", price=8.0, median_s=8.0)
    record = tmp_path / "peers.csv"
    with record.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [*asdict(point), "yardstick_s", "recorded"])
        writer.writeheader()
        writer.writerow(asdict(point) | {"yardstick_s": 2.0, "recorded": "then"})
    (peer,) = peers_of(climbed, record)
    assert peer.price == pytest.approx(4 * climbed.points[-1].median_s)
    assert (peer.contender, peer.error, peer.unstable) == ("other", point.error, False)
    texts = {text.get_text() for text in error_against_price(climbed, [peer]).legends[0].get_texts()}
    assert "other (recorded)" in texts
    assert recorded_on(record) == "then"


# --- the command


def test_the_command_prints_writes_and_draws(tmp_path, capsys):
    assert status("cost", "skin-propagator", "--rounds", 1, "--out", tmp_path / "cost") == 0
    assert "1.00%:" in capsys.readouterr().out
    with (tmp_path / "cost" / "cost.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["setting"] for row in rows][:2] == ["5 kHz", "20 kHz"]
    assert {row["ladder"] for row in rows} == {"skin-propagator"}
    assert min(float(row["peak_bytes"]) for row in rows) > 0
    assert (tmp_path / "cost" / "skin-propagator.png").stat().st_size > 10_000


def test_the_command_writes_a_page(tmp_path):
    assert status("cost", "spectral-sensitivity", "--rounds", 1, "--page", tmp_path / "all.md") == 0
    text = (tmp_path / "all.md").read_text(encoding="utf-8")
    assert "## spectral-sensitivity" in text
    assert "| padded to 1.6 s | 1.8e-03 | 1.6 |" in text
    assert "![error against price](all/spectral-sensitivity.svg)" in text
    assert (tmp_path / "all" / "spectral-sensitivity.svg").read_text(encoding="utf-8").startswith("<?xml")
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert status("cost", "spectral-sensitivity", "--rounds", 1, "--page", tmp_path / "file" / "all.md") == 3


def test_the_command_as_json(capsys):
    assert status("cost", "reversal-time-amplitude", "--rounds", 1, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert "numpy" in said["machine"]
    assert len(said["ladders"]["reversal-time-amplitude"]["points"]) == 6


def test_an_unknown_ladder_names_the_nearest(capsys):
    assert status("cost", "skin-propagater") == 2
    assert "did you mean 'skin-propagator'?" in capsys.readouterr().err


def test_unwritable_path_is_reported_in_one_sentence(tmp_path, capsys):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert status("cost", "reversal-time-amplitude", "--rounds", 1, "--out", tmp_path / "file") == 3
    assert "cannot write" in capsys.readouterr().err
