"""Items of `tactometry reproduce`, and docs/explanation/reproduced.md."""

import csv
import json
import math
import re

import numpy as np
import pytest
from command_line import output, refused
from matplotlib.figure import Figure
from places import DOCS

from tactometry.errors import InvalidParameter
from tactometry.experiments.thesis import REPRODUCTIONS, reproduction_of
from tactometry.experiments.thesis.figures.electrovibration import force_against_area
from tactometry.experiments.thesis.figures.writing import points, write_drawing
from tactometry.experiments.thesis.findings import opened_contact
from tactometry.experiments.thesis.page import captions, page, reason_for
from tactometry.experiments.thesis.reproduction import Number, reproduce
from tactometry.experiments.thesis.studies import experiment
from tactometry.observers.finger import SimulatedFinger
from tactometry.session.request import Press
from tactometry.stimuli.electrovibration.attraction.force import LAWS
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.stimulus.sensation import free_displacement, loaded_displacements

PAGE = DOCS / "explanation" / "reproduced.md"
QUICK = ("table-2.1", "table-4.1", "table-6.1", *(name for name in REPRODUCTIONS if "figure" in name))
DRAWN_AT_ONCE = ("figure-3.4", "figure-5.8", "figure-6.3", "figure-6.5", "figure-6.6", "figure-6.8", "figure-B.1")
ONE_IN_THE_THIRD_DIGIT, NO_MORE_THAN_ROUNDING = 0.0101, 1e-9
"""How far a number on the page may be off: relative, and, where the page says 0, in its unit."""


def number(**changes):
    return Number(**{"quantity": "q", "condition": "c", "value": 1.0, "unit": "m", "origin": "derived", **changes})


# --- labels


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"stated": "1 m", "holds": True}, "**reproduced**"),
        ({"stated": "1 m", "holds": True, "origin": "calibrated"}, "agrees, as calibrated"),
        ({"stated": "1 m", "holds": True, "origin": "assumed"}, "agrees, as assumed"),
        ({"stated": "2 m", "holds": False}, "does not agree"),
        ({}, "not compared"),
    ],
)
def test_only_derived_numbers_that_agree_are_reproduced(changes, expected):
    assert number(**changes).verdict == expected


def test_unknown_origin_is_refused():
    with pytest.raises(InvalidParameter, match=r"Number.origin: found 'guessed', expected one of derived"):
        number(origin="guessed")


# --- items


@pytest.mark.parametrize("name", REPRODUCTIONS)
def test_item_states_source_and_assumptions(name):
    item = reproduction_of(name)
    assert item.title
    assert item.stated.endswith(".") or (not item.stated and name.startswith("figure"))
    assert item.assumes.endswith(".")
    assert (item.numbers is None) != (item.drawing is None)
    assert item.outcome or not name.startswith("finding")


@pytest.fixture(
    scope="module",
    params=[name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in REPRODUCTIONS],
)
def made(request):
    return reproduce(reproduction_of(request.param))


def test_numbers_are_unique_and_compared_with_statements(made):
    places = [(each.quantity, each.condition) for each in made.numbers]
    assert len(set(places)) == len(places)
    assert all((each.holds is not None) == bool(each.stated) for each in made.numbers)
    assert all(math.isfinite(each.value) for each in made.numbers)
    assert made.item.outcome or all(each.holds is not False for each in made.compared)


def test_page_is_that_of_the_command(made):
    name = made.item.name
    now, then = (words_of(text, name) for text in (page([made]), PAGE.read_text(encoding="utf-8")))
    assert [word for word in now if not is_number(word)] == [word for word in then if not is_number(word)], "make pages"
    found, stated = ([float(word) for word in words if is_number(word)] for words in (now, then))
    np.testing.assert_allclose(
        found, stated, rtol=ONE_IN_THE_THIRD_DIGIT, atol=NO_MORE_THAN_ROUNDING, err_msg="make pages"
    )


def words_of(text, name):
    """Return the words of an item's section and of its table rows."""
    section = text.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
    rows = [line for line in text.splitlines() if line.startswith(f"| {name} |")]
    return " ".join([*rows, section]).replace("(", "( ").replace(")", " )").split()


def is_number(word):
    return re.fullmatch(r"-?[\d.]+(e[+-]?\d+)?", word) is not None


def test_page_has_each_item_once_and_in_order():
    text = PAGE.read_text(encoding="utf-8")
    sections = re.findall(r"^## (\w+-[\w.]+)$", text, re.MULTILINE)
    assert sections == [name for name in REPRODUCTIONS if not name.startswith("figure")]
    figures = re.findall(r"^\| (figure-[\w.]+) \|", text.partition("\n## Figures\n")[2], re.MULTILINE)
    assert sorted(figures) == sorted(name for name in REPRODUCTIONS if name.startswith("figure"))


N_FIGURES = {"2": 37, "3": 22, "4": 34, "5": 13, "6": 15, "A": 7, "B": 2}
N_TABLES = {"2": 2, "3": 5, "4": 5, "5": 1, "6": 3}


def test_each_caption_is_made_or_has_a_reason():
    kinds = {"figure": N_FIGURES, "table": N_TABLES}
    listed = [f"{kind}-{part}.{n + 1}" for kind, of in kinds.items() for part, last in of.items() for n in range(last)]
    assert sorted(captions()) == sorted(listed)


# --- numbers that are known otherwise


@pytest.mark.parametrize(
    ("name", "origin"), [("figure-6.15", "assumed"), ("figure-4.11", "assumed"), ("figure-3.20", "calibrated")]
)
def test_figure_of_a_chosen_input_is_not_derived(name, origin):
    """Inputs of 6.15, 4.11 and 3.20 are chosen or set, not derived."""
    assert reproduction_of(name).origin == origin


def of_variants(name):
    rows = {}
    for each in reproduce(reproduction_of(name)).numbers:
        if not each.part:
            rows.setdefault(each.condition, {})[each.quantity] = each
    return rows


@pytest.mark.slow
def test_outcome_of_finding_3_follows_from_its_rows():
    rows = of_variants("finding-3")
    falls = {name: [row[f"from 0.5 to 3 N, {f} Hz"].value for f in (60, 120, 240, 480)] for name, row in rows.items()}
    by_area = -10 / 3 * math.log10(3.0 / 0.5)
    assert falls["default"] == pytest.approx([by_area] * 4, abs=1e-3)
    assert falls["a fixed fraction of the load is detected"] == pytest.approx([-2 * by_area] * 4, abs=1e-3)
    assert falls["area summed by Pacini"] == pytest.approx([by_area, *[1.5 * by_area] * 3], abs=1e-3)
    resistive = falls["sine, body resistance of 10 kohm"]
    assert resistive == sorted(resistive)
    softer = falls["stiffness of the skin as F^(2/3)"]
    assert softer[0] > 1 > abs(softer[1])
    assert softer[3] < softer[2] < -1
    lowest_hz = {name: row["lowest threshold at"].value for name, row in rows.items()}
    assert (lowest_hz["a pad that slides"], lowest_hz["the same, damped by 0.05 N s/m"]) == (240, 60)
    assert not any(all(each.holds is not False for each in row.values()) for row in rows.values())


def test_contact_that_opens_loses_as_much_as_one_that_holds():
    """Finding 1: the focus decreases with force for both contacts."""
    opened_m = np.abs(opened_contact(3.0).displacement_m).max()
    stimulus = next(iter(experiment("time-reversal-threshold").cells.values())).stimulus
    setup = stimulus.setup
    free_m = free_displacement(stimulus.at(20.0), setup, setup.focus_m)
    held_m = loaded_displacements(free_m[None], setup, [Fingertip().load(setup.focus_m, 3.0)])
    assert opened_m == pytest.approx(np.abs(held_m).max(), rel=5e-3)


def test_forces_of_table_6_2_are_those_in_the_band():
    """Compare with a 15 % lognormal spread, truncated at 20 %, by quadrature."""
    finger, rng = SimulatedFinger(waver_cv=0.0), np.random.default_rng(6)
    request = Press("s", 1.0, target_n=1.0, tolerance=0.2, hold_s=0.5, duration_s=0.02, timeout_s=1.0)
    touched = np.array([finger.hold(request, rng).forces_n.mean() for _ in range(2000)])
    ratios = np.linspace(0.8, 1.2, 4001)
    density = np.exp(-(np.log(ratios) ** 2) / (2 * 0.15**2)) / ratios
    mean = np.average(ratios, weights=density)
    sd = math.sqrt(np.average((ratios - mean) ** 2, weights=density))
    assert touched.mean() == pytest.approx(mean, abs=3.9 * sd / math.sqrt(touched.size))  # 1e-4


def test_table_6_1_has_the_published_closed_forms():
    numbers = {each.quantity: each for each in reproduce(reproduction_of("table-6.1")).numbers}
    published = {
        "capacitance of the insulator": 3.4531332,
        "capacitance of the corneum": 4.4270939,
        "resistance of the corneum": 40.0,
        "share of a fast voltage across the corneum": 0.438202247,
        "time constant": 315.209086,
        "corner of the high-pass": 504.918640,
    }
    assert {name: numbers[name].value for name in published} == pytest.approx(published)
    assert {numbers[name].origin for name in ("time constant", "corner of the high-pass")} == {"calibrated"}


# --- the command


def test_item_is_written_with_its_origins(capsys, tmp_path):
    words = ("reproduce", "table-6.1", "--out", tmp_path, "--page", tmp_path / "page.md")
    said = output(capsys, *words)
    with (tmp_path / "table-6.1.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["origin"] for row in rows] == ["assumed"] * 6 + ["derived"] * 3 + ["calibrated"] * 3
    assert all(f"{row['quantity']}, {row['condition']}: " in said for row in rows)
    assert (tmp_path / "page.md").read_text(encoding="utf-8") == page([reproduce(reproduction_of("table-6.1"))])
    numbers = json.loads(output(capsys, *words[:2], "--json"))["table-6.1"]["numbers"]
    assert [each["origin"] for each in numbers] == [row["origin"] for row in rows]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("table-4.33", "NAME: found 'table-4.33', expected one of all, "),
        *(
            (name, f"NAME: found {name}, expected an item that can be reproduced: this is {reason_for(name)}")
            for name in ("figure-6.7", "table-3.4")
        ),
    ],
)
def test_unknown_item_is_refused_with_the_reason(name, sentence, capsys):
    assert refused(capsys, "reproduce", name).startswith(f"tactometry: {sentence}")


def test_caption_is_made_with_the_item_that_includes_it(capsys, tmp_path):
    output(capsys, "reproduce", "figure-6.10", "--out", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"figure-6.8.csv", "figure-6.8.png"}


# --- curves of a drawing


def test_drawing_is_written_as_picture_and_curves(tmp_path):
    figure = force_against_area()
    write_drawing(figure, tmp_path, "area")
    assert (tmp_path / "area.png").stat().st_size > 5_000
    with (tmp_path / "area.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["curve"] for row in rows} == set(LAWS)
    assert [(row["curve"], float(row["x"]), float(row["y"])) for row in rows] == [
        (row[1], row[3], row[5]) for row in points(figure)
    ]


def test_points_have_names_of_ticks_and_error_bars():
    figure = Figure()
    axes = figure.add_subplot()
    axes.errorbar([0.5, 1.5], [0, 1], xerr=0.1, label="P0")
    axes.set_yticks([0, 1], ["Dull", "Bad\nGood"])
    found = [(curve, x, y, place) for _, curve, _, x, _, y, place in points(figure)]
    assert found == [("P0", 0.5, 0.0, "Dull"), ("P0", 1.5, 1.0, "Bad Good")]


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[] if n in DRAWN_AT_ONCE else pytest.mark.slow) for n in REPRODUCTIONS if "figure" in n],
)
def test_figure_has_finite_curves(name):
    rows = list(points(reproduction_of(name).drawing()))
    assert rows
    assert all(math.isfinite(x) and math.isfinite(y) for _, _, _, x, _, y, _ in rows)
