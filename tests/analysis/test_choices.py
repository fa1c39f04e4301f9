"""Tests of signal detection (science 11.3), same-different and preference analyses."""

import re

import numpy as np
import pandas as pd
import pytest
from examples import examples
from hypothesis import given, strategies as st
from scipy.special import expit, logit, ndtri
from scipy.stats import binomtest, norm, t as student

from tactometry.analysis.distributions import exact_interval
from tactometry.analysis.figures.psychophysics import share_figure
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.report.summary import summary
from tactometry.analysis.tasks.preference import ORDER, bradley_terry, preference_table, share_table
from tactometry.analysis.tasks.same_different import differencing_sensitivity, independent_sensitivity
from tactometry.analysis.tasks.signal_detection import (
    forced_choice_chance,
    forced_choice_sensitivity,
    yes_no_sensitivity,
)
from tactometry.cli.analyse import summary_text
from tactometry.errors import InvalidParameter

N = 200_000
TEAMS = ("Milwaukee", "Detroit", "Toronto", "New York", "Boston", "Cleveland", "Baltimore")
WINS = "- 7 9 7 7 9 11  6 - 7 5 11 9 9  4 6 - 7 7 8 12  6 8 6 - 6 7 10  6 2 6 7 - 7 12  4 4 5 6 6 - 6  2 4 1 3 1 7 -"


def counts(d_prime, differ, rng) -> tuple[int, int, int, int]:
    """Draw hits and false alarms; the stimuli are at -d'/2 and d'/2."""
    side = np.where(rng.random(N) < 0.5, 0.5, -0.5) * d_prime
    x, y, z = (mean + rng.standard_normal(N) for mean in (side, -side, side))
    return int(differ(x, y).sum()), N, int(differ(x, z).sum()), N


@pytest.mark.parametrize("d_prime", [0.8, 1.5, 3.0])
def test_d_prime_of_known_observers_is_recovered(d_prime) -> None:
    """Its standard error is below 0.02 at these numbers of trials."""
    rng = np.random.default_rng()
    for criterion in (1.0, 2.5):
        seen = counts(d_prime, lambda x, y, k=criterion: np.abs(x - y) > k, rng)
        assert differencing_sensitivity(*seen) == pytest.approx(d_prime, abs=0.08)
    seen = counts(d_prime, lambda x, y: (x > 0) != (y > 0), rng)
    assert independent_sensitivity(*seen) == pytest.approx(d_prime, abs=0.08)


def test_sensitivity_is_zero_without_excess_hits() -> None:
    for rule in (differencing_sensitivity, independent_sensitivity):
        assert rule(10, 50, 30, 50) == 0.0
        assert rule(0, 50, 0, 50) == 0.0
        assert np.isfinite(rule(50, 50, 0, 50))


def test_impossible_counts_are_refused() -> None:
    with pytest.raises(InvalidParameter, match="n_hits: found 51, expected a count from 0 to n_different"):
        differencing_sensitivity(51, 50, 0, 50)
    with pytest.raises(InvalidParameter, match="n_same: found 0, expected at least 1"):
        independent_sensitivity(5, 50, 0, 0)


def league() -> tuple[list[str], list[str], list[int]]:
    """American League East 1987, without home advantage: each pair equally often in either order."""
    wins = np.array([0 if word == "-" else int(word) for word in WINS.split()]).reshape(7, 7)
    rows = [(a, b) for i, a in enumerate(TEAMS) for j, b in enumerate(TEAMS) for _ in range(wins[i, j])]
    both = [(a, b, 1) for a, b in rows] + [(b, a, 2) for a, b in rows]
    first, second, preferred = zip(*both, strict=True)
    return list(first), list(second), list(preferred)


def test_published_worths_of_baseball_teams() -> None:
    """Agresti (2002), Categorical Data Analysis, table 10.10, relative to Baltimore."""
    found = bradley_terry(*league())
    worth = found.set_index("item")["worth"].drop(ORDER)
    against = (worth - worth["Baltimore"])[["Milwaukee", "Detroit", "Toronto", "New York", "Cleveland"]]
    np.testing.assert_allclose(against, [1.581, 1.436, 1.294, 1.248, 0.684], atol=6e-4)
    assert worth.mean() == pytest.approx(0, abs=1e-12)
    assert found["worth"].iloc[-1] == pytest.approx(0, abs=1e-9)


def compared(rng, n_participants, n_each, worths, order=0.4) -> pd.DataFrame:
    """Draw all ordered pairs, `n_each` times by each participant."""
    names = list(worths)
    pairs = [(a, b) for a in names for b in names if a != b]
    rows = [(f"P{p + 1:02d}", *pair) for p in range(n_participants) for pair in pairs for _ in range(n_each)]
    table = pd.DataFrame(rows, columns=["participant", "item", "item_b"])
    chance = expit(table["item"].map(worths) - table["item_b"].map(worths) + order)
    return table.assign(response=np.where(rng.random(len(table)) < chance, 1, 2))


TRUTH = {"P0": -1.0, "P1": 0.0, "P2": 0.3, "P3": 0.7}


@pytest.mark.parametrize("n_participants", [3, 12])
def test_worths_and_order_are_recovered_within_their_errors(n_participants) -> None:
    table = compared(np.random.default_rng(), n_participants, 120 // n_participants, TRUTH)
    people = table["participant"].tolist()
    found = bradley_terry(table["item"], table["item_b"], table["response"], people)
    errors = (found["worth"] - [*TRUTH.values(), 0.4]) / found["standard_error"]
    assert np.abs(errors).max() < 8
    alone = bradley_terry(table["item"], table["item_b"], table["response"])
    np.testing.assert_allclose(found["worth"], alone["worth"], rtol=1e-9)
    same = np.allclose(found["standard_error"], alone["standard_error"], rtol=1e-9)
    assert same == (n_participants < 5)


@pytest.mark.parametrize("people", [None, list("ppqqrrssttuu")])
def test_worths_are_disconnected_when_first_always_wins(people) -> None:
    found = bradley_terry(["a", "b"] * 6, ["b", "a"] * 6, [1] * 12, people)
    assert set(found["note"]) == {"no finite worths: the order within a pair determined every preference"}
    assert found["worth"].isna().all()


@pytest.mark.parametrize(("n", "reach"), [(4, norm.ppf(0.975)), (5, student.ppf(0.975, 4))])
def test_worth_intervals_use_participants_from_five_on(n, reach) -> None:
    first, second, preferred = league()
    people = [f"P{place % n}" for place in range(len(first))]
    found = bradley_terry(first, second, preferred, people)
    np.testing.assert_allclose((found["high"] - found["worth"]) / found["standard_error"], reach, rtol=1e-9)


def test_worths_of_two_items_have_closed_form() -> None:
    """The logits are w_a - w_b + o and w_b - w_a + o, with variances 1 / k + 1 / (n - k)."""
    (k, n), (j, m) = (30, 40), (12, 36)
    preferred = [1] * k + [2] * (n - k) + [1] * j + [2] * (m - j)
    found = bradley_terry(["a"] * n + ["b"] * m, ["b"] * n + ["a"] * m, preferred)
    one, other, variance = logit(k / n), logit(j / m), 1 / k + 1 / (n - k) + 1 / j + 1 / (m - j)
    half = (one - other) / 4
    np.testing.assert_allclose(found["worth"], [half, -half, (one + other) / 2], rtol=1e-9)
    np.testing.assert_allclose(found["standard_error"], np.sqrt(variance) / [4, 4, 2], rtol=1e-7)


def test_preference_table_drops_constant_factor() -> None:
    first, second, preferred = league()
    rows = pd.DataFrame({"item": first, "item_b": second, "response": list(map(str, preferred))})
    rows = rows.assign(task="preference", participant="P1", hz=60.0, force_n=np.where(rows.index % 2, 0.5, 1.0))
    found = preference_table(rows, ("hz", "force_n"))
    assert "hz" not in found.columns
    assert found["force_n"].value_counts().to_dict() == {0.5: 8, 1.0: 8}


def test_worths_have_note_when_item_never_wins() -> None:
    found = bradley_terry(["a", "a", "b", "b"], ["b", "c", "c", "a"], [1, 1, 1, 1])
    assert set(found["note"]) == {"no finite worths: c never preferred to a, b"}
    assert found["worth"].isna().all()
    assert found["n_preferred"].tolist() == pytest.approx([2, 2, 0, np.nan], nan_ok=True)


def test_exact_interval_equals_scipy_binomial() -> None:
    for k, n in ((0, 7), (1, 1), (3, 12), (12, 12), (40, 90)):
        peer = binomtest(k, n).proportion_ci(0.95, method="exact")
        assert exact_interval(k, n) == pytest.approx((peer.low, peer.high), abs=1e-9)


def test_share_figure_draws_each_share_with_interval() -> None:
    rng = np.random.default_rng()
    rows = pd.concat([compared(rng, 2, 3, TRUTH).assign(force_n=force, source="t.csv") for force in (0.5, 2.0)])
    shares = share_table(rows, ["force_n"])
    assert shares["n_pairs"].tolist() == [rows["item"].isin([item]).sum() for item in [*TRUTH] * 2]
    assert (shares["share"] == shares["n_preferred"] / shares["n_pairs"]).all()
    items = list(TRUTH)
    (axes,) = share_figure(shares, items).figure.axes
    drawn = {line.get_label(): line.lines[0].get_xdata().tolist() for line in axes.containers}
    of_force = shares.groupby("force_n")["share"].apply(list)
    assert drawn == {"0.5 N": of_force[0.5], "2 N": of_force[2.0]}
    assert [label.get_text() for label in axes.get_yticklabels()] == items


def written(path, table, columns, factors=()):
    table = table.assign(trial=range(1, len(table) + 1), procedure="constant_stimuli")
    table[["participant", "trial", *factors, "procedure", *columns]].to_csv(path, index=False)
    return path


def test_both_are_analysed_and_reported(tmp_path) -> None:
    rng = np.random.default_rng()
    table = compared(rng, 6, 8, TRUTH).assign(task="preference", level="", catch="")
    rows = [("P01", int(rng.random() < (0.8 if c == 0 else 0.04)), c) for c in (0, 1) for _ in range(50)]
    same = pd.DataFrame(rows, columns=["participant", "response", "catch"])
    same = same.assign(task="same_different", level=np.where(same["catch"] == 1, "", "20"), item="", item_b="")
    columns = ["level", "task", "response", "catch", "item", "item_b"]
    found = analyse(written(tmp_path / "t.csv", pd.concat([table, same]), columns), report=tmp_path / "r.html")
    assert found.warnings == ()
    assert found.tables["same_different"]["n_same"].tolist() == [50]
    assert 1.5 < found.tables["same_different"]["d_prime_differencing"][0] < 6
    assert found.tables["preference"]["item"].tolist() == [*TRUTH, "first of the pair"]
    assert found.tables["preference"]["low"].notna().all()
    assert found.tables["preference_shares"]["item"].tolist() == [*TRUTH]
    assert summary(found)["preference"][0]["item"] == "P0"
    caption = "Share of its pairs in which each item was preferred, pooled over participants"
    page = found.report.read_text()
    for text in ("<h2>Preferences</h2>", "<h2>Same or different</h2>", "Bradley-Terry", "differencing", caption):
        assert text in page


def test_compared_factor_is_not_a_force_condition(tmp_path) -> None:
    table = compared(np.random.default_rng(), 4, 8, TRUTH)
    table = table.assign(task="preference", level="20", place="", force_mean_n=1.1)
    columns = ["level", "task", "response", "item", "item_b", "force_mean_n"]
    found = analyse(written(tmp_path / "t.csv", table, columns, ["place"]))
    assert found.trials.factors == ()
    assert found.tables["force"]["text"].str.startswith("1.10 ± ").all()
    assert "applied force" in summary_text(found)


@pytest.mark.parametrize(
    ("rate", "values"),
    [(0.75, (0.95387, 1.4338, 1.6822)), (0.70711, (0.7707, 1.2647, 1.5191)), (0.79370, (1.1587, 1.6232, 1.8650))],
)
def test_published_sensitivities_of_forced_choices(rate: float, values: tuple[float, ...]) -> None:
    found = [forced_choice_sensitivity(rate, m) for m in (2, 3, 4)]
    assert found == pytest.approx(list(values), abs=1e-4)


def test_published_chances_at_unit_sensitivity() -> None:
    found = [forced_choice_chance(1.0, m) for m in (2, 3, 4)]
    assert found == pytest.approx([0.76025, 0.63370, 0.55203], abs=5e-6)


def test_log_linear_rule_of_perfect_answers() -> None:
    found = yes_no_sensitivity(20, 20, 0, 20)
    assert (found.d_prime, found.criterion) == (pytest.approx(3.9615, abs=5e-5), pytest.approx(0.0, abs=1e-12))


def test_lenient_observer_has_negative_criterion() -> None:
    found = yes_no_sensitivity(19, 20, 9, 20)
    assert found.criterion == pytest.approx(-(ndtri(19.5 / 21) + ndtri(9.5 / 21)) / 2)
    assert found.criterion < 0


@given(rate=st.floats(0.01, 0.999))
@examples(30)
def test_two_alternatives_have_a_closed_form(rate: float) -> None:
    """d' = sqrt(2) z(Pc)."""
    assert forced_choice_sensitivity(rate, 2) == pytest.approx(np.sqrt(2) * ndtri(rate), abs=1e-9)


@given(d=st.floats(-2, 5), m=st.integers(2, 8))
@examples(30)
def test_sensitivity_inverts_percent_correct(d: float, m: int) -> None:
    assert forced_choice_sensitivity(forced_choice_chance(d, m), m) == pytest.approx(d, abs=1e-6)


@given(m=st.integers(2, 10))
def test_zero_sensitivity_has_chance_level(m: int) -> None:
    assert forced_choice_chance(0.0, m) == pytest.approx(1 / m, rel=1e-10)


@given(hits=st.integers(0, 30), alarms=st.integers(0, 30))
def test_mirrored_answers_negate_the_criterion(hits: int, alarms: int) -> None:
    here, mirrored = yes_no_sensitivity(hits, 30, alarms, 30), yes_no_sensitivity(30 - alarms, 30, 30 - hits, 30)
    assert mirrored.d_prime == pytest.approx(here.d_prime, abs=1e-12)
    assert mirrored.criterion == pytest.approx(-here.criterion, abs=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: yes_no_sensitivity(3, 2, 0, 5), "n_hits: found 3, expected a count from 0 to n_signals (2)"),
        (lambda: yes_no_sensitivity(-1, 2, 0, 5), "n_hits: found -1, expected a count from 0 to n_signals (2)"),
        (lambda: yes_no_sensitivity(1, 2, 0, 0), "n_noises: found 0, expected at least 1"),
        (lambda: forced_choice_chance(1.0, 1), "n_alternatives: found 1, expected a whole number from 2"),
        (lambda: forced_choice_chance(np.inf, 2), "d_prime: found inf, expected a finite number"),
        (lambda: forced_choice_sensitivity(1.0, 3), "rate_correct: found 1.0, expected a rate between "),
    ],
)
def test_impossible_arguments_are_rejected(call, message: str) -> None:
    with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}"):
        call()
