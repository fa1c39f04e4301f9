"""Tests of adjustment settings and magnitude estimates."""

import csv
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.report.page import figures_of, render
from tactometry.analysis.report.summary import summary
from tactometry.analysis.report.texts import outcome_sentences
from tactometry.analysis.result import Analysis
from tactometry.cli.analyse import summary_text
from tactometry.errors import InvalidFile

HEADER = ("participant", "session", "trial", "force_n", "procedure", "level", "level_unit", "task", "response", "valid")
FORCES = (0.5, 1.0, 2.0)
LEVELS_DB = (6.0, 12.0, 18.0, 24.0)
SD = 1.2
CITED = ("<li>Stevens, S. S.", "<li>Lane", "<li>Rouder")
SET, NUMBER = r"the level that was set, within 1e\+15, or nothing", r"a number from 0 to 1e\+15, or nothing"


def written(path: Path, rows) -> Path:
    """Write rows of participant, force, level, unit, task, response, valid."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(HEADER)
        table.writerows((p, 1, n, force, "constant", *rest) for n, (p, force, *rest) in enumerate(rows, 1))
    return path


def settings(rng, n_repeats=10) -> list[tuple]:
    cells = product(range(6), FORCES, range(n_repeats))
    own = rng.normal(20, 2, 6)
    return [(f"P{p}", f, 10, "dB re 1 V", "adjustment", own[p] - 2 * f + rng.normal(0, SD), 1) for p, f, _ in cells]


@pytest.fixture(scope="module")
def adjusted(tmp_path_factory) -> tuple[list[tuple], Analysis]:
    rows = settings(np.random.default_rng())
    lost = [("P0", 0.5, 10, "dB re 1 V", "adjustment", *answer) for answer in ((99.0, 0), ("", 1))]
    return rows, analyse(written(tmp_path_factory.mktemp("adjusted") / "adjusted.csv", rows + lost))


def test_adjustment_setting_is_mean_with_t_interval(adjusted) -> None:
    from scipy.stats import t as student

    rows, found = adjusted
    own = np.array([row[5] for row in rows if row[:2] == ("P0", 0.5)])
    row = found.tables["adjustment"].iloc[0]
    assert (row["participant"], row["force_n"], row["n_settings"]) == ("P0", 0.5, 10)
    assert row["setting"] == pytest.approx(own.mean())
    assert row["sd"] == pytest.approx(own.std(ddof=1))
    ends = student.interval(0.95, 9, own.mean(), own.std(ddof=1) / np.sqrt(10))
    assert (row["setting_low"], row["setting_high"]) == pytest.approx(ends)


def test_settings_are_compared_as_differences_in_decibels(adjusted) -> None:
    (outcome,) = adjusted[1].outcomes
    assert (outcome.task, outcome.dependent) == ("adjustment", "setting")
    assert outcome.anova is not None
    difference = outcome.pairs["force_n"].iloc[1]["difference"]
    assert abs(difference + 3) < 4.5 * SD * np.sqrt(2 / 60)
    sentence = outcome_sentences(outcome, "dB re 1 V")["Pairs of force_n"][1]
    assert f"{difference:.2f} dB, 95 % simultaneous CI" in sentence


def test_the_report_shows_settings_without_rates_or_curves(adjusted) -> None:
    found = adjusted[1]
    assert [figure.name for figure in figures_of(found)] == ["setting"]
    page = render(found)
    for text in ("Setting by adjustment (dB re 1 V)", "Participants: adjustment (18 rows)", "Gescheider 1997"):
        assert text in page
    assert "setting by adjustment, dB re 1 V" in summary_text(found)
    assert summary(found)["adjustment"][0]["n_settings"] == 10
    assert not any("not analysed" in warning for warning in found.warnings)


def numbers(unit, n_participants=4, noise=0.0, rng=None) -> list[tuple]:
    """Return magnitudes k A ** (0.6 + 0.1 force), k per participant."""
    rng, rows = rng or np.random.default_rng(), []
    for p, force, level, _ in product(range(n_participants), FORCES, LEVELS_DB, range(3)):
        shown = level if unit.startswith("dB") else 10 ** (level / 20)
        magnitude = (1 + 5 * p) * 10 ** (level / 20 * (0.6 + 0.1 * force)) * np.exp(noise * rng.normal())
        rows.append((f"P{p}", force, shown, unit, "magnitude", magnitude, 1))
    return rows


@pytest.mark.parametrize("unit", ["dB re 1 V", "V"])
def test_exponents_match_power_law_for_any_modulus(tmp_path, unit) -> None:
    catch = ("P0", 0.5, "", unit, "magnitude", 3.0, 1)
    found = analyse(written(tmp_path / "t.csv", [*numbers(unit), catch, ("P1", 1.0, 10, unit, "magnitude", 0, 1)]))
    table = found.tables["magnitude"]
    np.testing.assert_allclose(table["exponent"], 0.6 + 0.1 * table["force_n"].astype(float), rtol=1e-9)
    assert table["n_ratings"].tolist() == [12] * 4 + [13] + [12] * 7
    assert table["n_zero"].sum() == table["n_zero"][4] == 1
    growth = found.tables["magnitude_levels"]
    assert growth["n"].tolist() == [4] * 12
    slopes = np.log(growth["geometric_mean"]).groupby(growth["force_n"]).agg(lambda y: y.iloc[-1] - y.iloc[0])
    np.testing.assert_allclose(slopes / (18 / 20 * np.log(10)), [0.65, 0.7, 0.8], rtol=1e-9)


def test_growth_ignores_modulus_when_level_is_missing(tmp_path) -> None:
    rows = [row for row in numbers("dB re 1 V") if row[:3] != ("P3", 0.5, 24.0)]
    louder = [(*row[:5], row[5] * (1000 if row[0] == "P3" else 1), row[6]) for row in rows]
    one, other = (
        analyse(written(tmp_path / f"{n}.csv", each)).tables["magnitude_levels"]["geometric_mean"]
        for n, each in enumerate((rows, louder))
    )
    np.testing.assert_allclose(other / other[0], one / one[0], rtol=1e-9)


def test_exponents_are_recovered_and_their_intervals_cover_them(tmp_path) -> None:
    """Coverage of 120 intervals is 95 % within 4.1 standard errors."""
    rows = numbers("dB re 1 V", n_participants=40, noise=0.3, rng=np.random.default_rng())
    table = analyse(written(tmp_path / "t.csv", rows)).tables["magnitude"]
    truth = 0.6 + 0.1 * table["force_n"].astype(float)
    covered = (table["exponent_low"] < truth) & (truth < table["exponent_high"])
    assert covered.sum() > 120 * 0.95 - 4.1 * np.sqrt(120 * 0.95 * 0.05)


def test_the_report_draws_numbers_against_levels(tmp_path) -> None:
    found = analyse(written(tmp_path / "t.csv", numbers("V", noise=0.02)))
    assert [figure.name for figure in figures_of(found)] == ["exponent", "magnitude_levels"]
    page = render(found)
    for text in ("<h2>Exponent of magnitude estimates</h2>", "Level (V)", *CITED):
        assert text in page
    assert "<li>Moscatelli" not in page
    assert outcome_sentences(found.outcomes[0], "V")["Pairs of force_n"][0].startswith("1 N − 0.5 N: 0.0")


def test_exponent_is_missing_with_too_few_levels(tmp_path) -> None:
    one = [row for row in numbers("V") if row[2] == 10 ** (6 / 20)]
    table = analyse(written(tmp_path / "one.csv", one)).tables["magnitude"]
    assert table["exponent"].isna().all()
    assert set(table["note"]) == {"no exponent: fewer than two levels with a number above 0"}
    two = [row for row in numbers("V") if row[2] < 4]
    table = analyse(written(tmp_path / "two.csv", two)).tables["magnitude"]
    assert table["exponent"].notna().all()
    assert table["exponent_low"].isna().all()
    with pytest.raises(InvalidFile, match=r"row 2, column 'level': found -3, expected an amplitude above 0"):
        analyse(written(tmp_path / "bad.csv", [("P0", 0.5, -3, "V", "magnitude", 4, 1)]))


@pytest.mark.parametrize(
    ("task", "answer", "expected"),
    [
        *(("adjustment", answer, SET) for answer in ("loud", "1e16", "1_0", "inf")),
        *(("magnitude", answer, NUMBER) for answer in ("-3", "nan")),
        ("preference", "3", r"1 \(item was preferred\), 2 \(item_b\) or nothing"),
    ],
)
def test_invalid_answer_is_rejected_with_its_row(tmp_path, task, answer, expected) -> None:
    rows = [("P0", 0.5, 1, "V", task, each, 1) for each in ("1.0", "", answer)]
    with pytest.raises(InvalidFile, match=rf"row 4, column 'response': found '{answer}', expected {expected}"):
        analyse(written(tmp_path / "t.csv", rows))


def test_zero_magnitudes_are_reported_without_exponent(tmp_path) -> None:
    rows = [(*row[:5], 0, 1) for row in numbers("V")]
    found = analyse(written(tmp_path / "t.csv", rows), report=tmp_path / "t.html")
    assert found.tables["magnitude"]["exponent"].isna().all()
    assert "magnitude_levels" not in found.tables


@pytest.mark.parametrize("answer", ["", "7"])
def test_measurements_alone_are_rejected(tmp_path, answer) -> None:
    table = written(tmp_path / "m.csv", [("P1", 0.5, 10, "dB re 1 um", "measurement", answer, 1)])
    with pytest.raises(InvalidFile, match=r"no valid answer to a task \(yes_no, forced_choice, comparison, same_diff"):
        analyse(table)


@pytest.mark.parametrize(("rows", "is_compared"), [(settings, True), (None, False)], ids=["settings", "exponents"])
def test_equivalence_applies_to_levels_only(tmp_path, rows, is_compared) -> None:
    rng = np.random.default_rng()
    path = written(tmp_path / "t.csv", rows(rng) if rows else numbers("dB re 1 V", noise=0.1, rng=rng))
    (outcome,) = analyse(path, plan=AnalysisPlan(equivalence={"force_n": 50.0})).outcomes
    assert ("force_n" in outcome.equivalence) == is_compared
