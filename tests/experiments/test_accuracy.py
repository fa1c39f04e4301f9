"""Properties of every accuracy problem, and output of `tactometry cost`."""

import csv
import json
import math
from dataclasses import asdict, replace
from functools import partial

import pytest
from command_line import output, status
from places import DOCS
from soak import SOAK

from tactometry.experiments.accuracy import PROBLEMS, problem_of
from tactometry.experiments.accuracy.figures import error_against_price
from tactometry.experiments.accuracy.measure import (
    PEERS,
    Problem,
    Reference,
    Setting,
    cold_s,
    measure,
    peers_of,
    recorded_on,
)
from tactometry.experiments.accuracy.page import answers, digit, label, table

PAGE = DOCS / "explanation" / "cost.md"
N_SETTINGS = {} if SOAK else {"group-threshold": 3}
"""In the reduced form, of each contender."""


def reduced(problem: Problem) -> Problem:
    contenders = dict.fromkeys(setting.contender for setting in problem.settings)
    groups = [[setting for setting in problem.settings if setting.contender == name] for name in contenders]
    n = N_SETTINGS.get(problem.name)
    return replace(problem, settings=tuple(setting for group in groups for setting in group[:n]))


DEAR = ("procedures", "group-threshold", "scene-hybrid-screen")
CHOSEN = [pytest.param(name, marks=pytest.mark.slow if name in DEAR else ()) for name in PROBLEMS]


@pytest.fixture(scope="module", params=CHOSEN)
def found(request):
    return measure(reduced(problem_of(request.param)), n_rounds=0)


# --- laws of every problem


def test_error_falls_from_setting_to_setting(found):
    for contender in found.contenders:
        errors = [max(point.error, found.floor) for point in found.of(contender)]
        assert len(errors) >= 2
        assert errors == sorted(errors, reverse=True)
        assert errors[0] > 1.5 * errors[-1]
    assert not any(point.unstable for point in found.points)


@pytest.mark.slow
def test_reference_agrees_with_an_independent_one(found):
    assert found.floor < found.points[0].error / 10
    independent = found.problem.independent
    if independent is not None:
        assert found.problem.error(independent.answer(), found.answer) <= found.floor + independent.uncertainty
        assert independent.uncertainty < found.points[0].error / 2


def test_errors_are_the_same_in_every_run(found):
    setting, point = found.problem.settings[0], found.points[0]
    assert found.problem.error(setting.run(), found.answer) == pytest.approx(point.error, rel=1e-6, abs=found.floor)


def test_table_fits_a_terminal_and_names_cheapest_settings(found):
    lines = table(found).splitlines()
    assert max(map(len, lines[3:])) <= 100
    assert [line.split(":")[0] for line in lines[-4:]] == ["10.00%", "1.00%", "0.10%", "0.01%"]


def test_page_states_the_errors_of_this_run(found):
    stated = stated_errors(found.problem.name)
    for point in found.points:
        assert max(stated[label(point)], found.floor) == pytest.approx(max(point.error, found.floor), rel=0.1)
    assert (PAGE.with_suffix("") / f"{found.problem.name}.svg").stat().st_size > 10_000


def stated_errors(problem: str) -> dict[str, float]:
    section = PAGE.read_text(encoding="utf-8").partition(f"\n## {problem}\n")[2].partition("\n## ")[0]
    cells = [[cell.strip() for cell in line.split("|")[1:3]] for line in section.splitlines() if line.startswith("| ")]
    return {setting: math.inf if error == "unstable" else float(error) for setting, error in cells[1:]}


# --- measuring a problem with known results


def halves(n: int) -> float:
    return 1 - 0.5**n if n < 30 else math.nan


def known(prices=(5.0, 3.0, 4.0, 9.0)) -> Problem:
    steps = (3, 7, 14, 40)
    settings = tuple(Setting(f"n = {n}", partial(halves, n), price) for n, price in zip(steps, prices, strict=True))
    return Problem("halves", Reference("one", lambda: 1.0, 1e-3), lambda a, b: abs(a - b), settings, "coins", "known")


@pytest.fixture(scope="module")
def coins():
    return measure(known(), n_rounds=1)


def test_point_has_price_times_and_size(coins):
    for point in coins.points:
        assert min(point.price, point.first_s, point.median_s) > 0
        assert point.spread_s >= 0
        assert point.answer_bytes == 8


def test_cold_time_is_that_of_a_new_process():
    """Each new process loads machine code; calls in one process load it once."""
    problem = problem_of("time-integration")
    short = replace(problem, settings=problem.settings[:2])
    here = [point.first_s for point in measure(short, n_rounds=1).points]
    cold = [point.first_s for point in measure(short, n_rounds=1, cold_s=partial(cold_s, problem.name)).points]
    assert here[1] < 0.1 < min(cold)


def test_result_that_is_not_finite_is_unstable(coins):
    assert [point.unstable for point in coins.points] == [False, False, False, True]
    assert coins.points[-1].error == math.inf
    assert "unstable" in table(coins)


def test_cheapest_setting_has_the_lowest_sufficient_price(coins):
    assert coins.cheapest(0.2).setting == "n = 7"
    assert coins.cheapest(2e-3).setting == "n = 14"
    assert answers(coins)[1] == "1.00%: n = 7, price 3"


def test_no_error_below_the_reference_is_reported(coins):
    assert coins.points[2].error < 1e-4
    assert coins.cheapest(1e-4) is None
    assert answers(coins)[3] == "0.01%: no setting reaches it"


def test_frontier_omits_points_surpassed_in_both(coins):
    assert [price for price, _ in coins.frontier] == [3.0, 4.0]


def test_one_more_digit_costs_the_factor_between_the_ends():
    curve = measure(known((2.0, 3.0, 5.0, 9.0)), n_rounds=1)
    digits = math.log10(0.125 / 1e-3)
    assert digit(curve) == f"x {2.5 ** (1 / digits):.2g}"
    assert digit(replace(curve, points=curve.points[:1])) == "nothing"


def test_figure_shows_settings_floor_and_unstable_points(coins):
    figure = error_against_price(coins)
    (axes,), (legend,) = figure.axes, figure.legends
    said = {text.get_text() for text in axes.texts}
    assert {"n = 3", "n = 7", "n = 14", "n = 40 (unstable)"} <= said
    assert {text.get_text() for text in legend.get_texts()} == {"tactometry", "cheapest", "reference's own error"}
    assert axes.get_xlabel() == "coins"
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_names_of_settings_do_not_overlap():
    curve = measure(known((5.0, 5.1, 5.2, 5.3)), n_rounds=1)
    near = [replace(point, contender="other", price=point.price * 1.01) for point in curve.points]
    (axes,) = error_against_price(curve, near).axes
    boxes = [text.get_window_extent() for text in axes.texts if text.get_visible() and "n =" in text.get_text()]
    assert len(boxes) >= 6
    assert not any(box.count_overlaps(boxes[:n]) for n, box in enumerate(boxes))


# --- other programs


def test_every_recorded_peer_is_on_the_page():
    with PEERS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = {row["contender"].split()[0].rstrip(",") for row in rows}
    assert {"finite", "scikit-fem", "solve_ivp", "psignifit", "questplus"} <= names
    for row in rows:
        assert f"{row['contender']}, {row['setting']}" in stated_errors(row["problem"])


def test_peer_is_priced_for_this_machine(tmp_path):
    curve = measure(known(), n_rounds=2)
    point = replace(curve.points[0], contender="other", setting="loose", price=8.0, median_s=8.0)
    record = tmp_path / "peers.csv"
    with record.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [*asdict(point), "yardstick_s", "recorded"])
        writer.writeheader()
        writer.writerow(asdict(point) | {"yardstick_s": 2.0, "recorded": "then"})
    (peer,) = peers_of(curve, record)
    assert peer.price == pytest.approx(4 * curve.points[-1].median_s)
    assert (peer.contender, peer.error, peer.unstable) == ("other", point.error, False)
    texts = {text.get_text() for text in error_against_price(curve, [peer]).legends[0].get_texts()}
    assert "other (recorded)" in texts
    assert recorded_on(record) == "then"


# --- the command


def test_command_prints_writes_and_draws(tmp_path, capsys):
    assert status("cost", "skin-propagator", "--rounds", 1, "--out", tmp_path / "cost") == 0
    assert "1.00%:" in capsys.readouterr().out
    with (tmp_path / "cost" / "cost.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["problem"], row["setting"]) for row in rows][:1] == [("skin-propagator", "5 kHz")]
    assert min(float(row["peak_bytes"]) for row in rows) > 0
    assert (tmp_path / "cost" / "skin-propagator.png").stat().st_size > 10_000


def test_command_writes_a_page_and_json(tmp_path, capsys):
    words = ("cost", "spectral-sensitivity", "--rounds", 1)
    output(capsys, *words, "--page", tmp_path / "all.md")
    text = (tmp_path / "all.md").read_text(encoding="utf-8")
    assert "## spectral-sensitivity" in text
    assert "| padded to 1.6 s | 1.8e-03 | 1.6 |" in text
    assert "![error against price](all/spectral-sensitivity.svg)" in text
    assert (tmp_path / "all" / "spectral-sensitivity.svg").read_text(encoding="utf-8").startswith("<?xml")
    said = json.loads(output(capsys, *words, "--json"))
    assert "numpy" in said["machine"]
    assert "padded to 1.6 s" in {point["setting"] for point in said["problems"]["spectral-sensitivity"]["points"]}


@pytest.mark.parametrize("option", ["--out", "--page"])
def test_command_reports_a_place_it_cannot_write(option, tmp_path, capsys):
    (tmp_path / "file").write_text("", encoding="utf-8")
    place = tmp_path / "file" / ("all.md" if option == "--page" else "")
    assert status("cost", "reversal-time-amplitude", "--rounds", 1, option, place) == 3
    assert "cannot write" in capsys.readouterr().err
