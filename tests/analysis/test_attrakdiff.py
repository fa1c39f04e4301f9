"""Tests of AttrakDiff scores, consistency, portfolio and comparisons."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from attrakdiff_answers import FORM, ITEMS, PATTERNS, raw_of, study
from command_line import output
from hypothesis import given, settings, strategies as st
from own_form import OWN_FORM
from study_texts import TUTORIAL

from tactometry.analysis.attrakdiff.scoring import (
    THESIS,
    against_reference,
    consistency,
    frequency_by_envelope,
    item_scores,
    portfolio,
    region,
    scores,
    summary,
    word_pairs,
)
from tactometry.analysis.figures.attrakdiff import portfolio_figure
from tactometry.analysis.outcomes.ratings import ratings
from tactometry.analysis.reading.origin import forms_of
from tactometry.analysis.reading.trials import read_trials
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.questionnaire import load

DIMENSIONS = ["PQ", "HQI", "HQS", "ATT", "HQ"]


def one_person(raw) -> pd.DataFrame:
    return pd.DataFrame({"participant": "P01", "item": ITEMS, "response": raw})


@pytest.fixture(scope="module")
def answers() -> pd.DataFrame:
    high = {name: 1.2 if frequency == "high" else 0.6 for name, (frequency, _) in THESIS.items()}
    return study(np.random.default_rng(), effect=high)


@pytest.fixture(scope="module")
def scored(answers) -> pd.DataFrame:
    return scores(answers)


@pytest.mark.parametrize(
    ("raw", "expected"),
    [(4, [0, 0, 0, 0, 0]), (7, [-3 / 7, 3 / 7, -3 / 7, -3 / 7, 0]), (1, [3 / 7, -3 / 7, 3 / 7, 3 / 7, 0])],
)
def test_the_same_answer_everywhere_has_the_published_scores(raw, expected) -> None:
    assert scores(one_person(raw))[DIMENSIONS].iloc[0].tolist() == pytest.approx(expected, abs=1e-12)


def test_the_best_answers_score_three() -> None:
    best = scores(one_person([raw_of(item, 3) for item in ITEMS]))
    assert best[DIMENSIONS].iloc[0].tolist() == [3.0] * 5
    assert best.attrs == {"questionnaire": load("attrakdiff"), "within": []}


@given(st.lists(st.integers(1, 7), min_size=28, max_size=28), st.randoms(use_true_random=False))
@settings(max_examples=30)
def test_the_order_of_the_answers_does_not_matter(raw, random) -> None:
    table = one_person(raw)
    order = random.sample(range(28), 28)
    one, other = scores(table)[DIMENSIONS], scores(table.iloc[order])[DIMENSIONS]
    assert other.to_numpy() == pytest.approx(one.to_numpy())


def test_scores_read_text_answers_and_skip_empty_ones() -> None:
    table = one_person([str(raw_of(item, 2)) for item in ITEMS])
    gaps = table.assign(response=table["response"].where(~table["item"].isin(["PQ1", "PQ2", "ATT1"]), ""))
    found = scores(gaps).iloc[0]
    assert (found["PQ"], found["ATT"], found["n_answered"]) == (2.0, 2.0, 25.0)
    lost = gaps.assign(response=gaps["response"].where(gaps["item"] != "PQ3", ""))
    assert pd.isna(scores(lost)["PQ"].iloc[0])
    assert scores(lost)["HQ"].iloc[0] == 2.0


def test_answers_given_twice_are_averaged() -> None:
    twice = pd.concat([one_person([raw_of(i, s) for i in ITEMS]) for s in (1, 2)])
    assert scores(twice)[DIMENSIONS].iloc[0].tolist() == pytest.approx([1.5] * 5)
    assert item_scores(twice)["score"].tolist() == pytest.approx([1.5] * len(ITEMS))


def test_conditions_are_the_columns_between_trial_and_procedure() -> None:
    table = one_person(4).assign(trial=1, pattern="P3", procedure="attrakdiff", task="rating")
    ordered = table[["participant", "trial", "pattern", "procedure", "task", "item", "response"]]
    assert list(scores(ordered).columns[:2]) == ["participant", "pattern"]
    assert list(scores(table.assign(hand="left"), within=["hand"]).columns[:2]) == ["participant", "hand"]


def test_the_short_form_is_read_by_its_name() -> None:
    mini = load("attrakdiff-mini")
    table = pd.DataFrame({"participant": "P1", "item": [i.id for i in mini.items], "response": 4})
    assert scores(table.assign(procedure="attrakdiff-mini"))["PQ"].tolist() == [0.0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.drop(columns="item"), "scores: found no column 'item'"),
        (lambda t: t.iloc[:0], "scores: found no row, expected answers to a questionnaire"),
        (lambda t: t.assign(item="PQ9"), "item, row 0: found 'PQ9', no item of attrakdiff; did you mean 'PQ"),
        (lambda t: t.assign(response=8), f"response, row 0: found 8 for {ITEMS[0]}, expected 1 to 7 or nothing"),
        (lambda t: t.assign(response="good"), f"response, row 0: found 'good' for {ITEMS[0]}, expected 1 to 7"),
        (lambda t: t.assign(response=3.5, row=99), f"response, row 99: found 3.5 for {ITEMS[0]}, expected 1 to 7"),
        (lambda t: pd.concat(t.assign(procedure=x) for x in ("attrakdiff", "sus")), "procedure: found attrakdiff, sus"),
    ],
)
def test_scores_reject_invalid_answers(change, message) -> None:
    with pytest.raises(InvalidParameter, match=re.escape(message)):
        scores(change(one_person(4)))


def test_intervals_are_those_of_participants_not_of_answers(answers, scored) -> None:
    from scipy.special import logit
    from scipy.stats import t

    row = summary(scored).set_index(["pattern", "dimension"]).loc[("P3", "PQ")]
    own = scored[scored["pattern"] == "P3"]["PQ"]
    half = t.ppf(0.975, 11) * own.std() / np.sqrt(12)
    mean, low, high = (logit((x + 3) / 6) for x in row[["mean", "mean_low", "mean_high"]].astype(float))
    slope = 6 / ((own.mean() + 3) * (3 - own.mean()))
    assert (mean - low, high - mean) == pytest.approx((slope * half, slope * half))
    assert row["n"] == 12


def test_word_pairs_keep_item_order_and_poles(answers) -> None:
    profile = word_pairs(item_scores(answers))
    assert len(profile) == 7 * 28
    first = profile.loc[0, ["pattern", "item", "negative", "positive"]]
    assert first.tolist() == ["P0", "PQ1", "Technical", "Human"]
    assert profile["dimension"].iloc[:28].tolist() == ["PQ"] * 7 + ["HQI"] * 7 + ["HQS"] * 7 + ["ATT"] * 7
    means = profile[profile["pattern"] == "P2"].groupby("dimension")["mean"].mean()
    own = summary(scores(answers)).query("pattern == 'P2'").set_index("dimension")["mean"]
    assert means["PQ"] == pytest.approx(own["PQ"])


def test_portfolio_names_regions_and_has_intervals(scored) -> None:
    found = portfolio(scored)
    assert list(found["pattern"]) == list(PATTERNS)
    assert ((found["PQ_low"] < found["PQ"]) & (found["PQ"] < found["PQ_high"])).all()
    assert [region(p, h) for p, h in zip(found["PQ"], found["HQ"], strict=True)] == found["region"].tolist()


def test_portfolio_label_is_within_the_figure(scored) -> None:
    drawn = portfolio_figure(portfolio(scored).rename(columns={"pattern": "condition"}))
    [(size, x)] = re.findall(r'font-size: (\d+)px[^>]* x="([^"]+)"[^>]*>Hedonic quality HQ', drawn.svg)
    assert float(x) > 0.93 * float(size)  # the ascent of a letter of DejaVu Sans


@pytest.mark.parametrize(
    ("pq", "hq", "name"),
    [(0, 0, "neutral"), (-1, 1, "neutral"), (1.01, 0, "task-oriented"), (0, 1.01, "self-oriented"), (None, 1, None)],
)
def test_regions_are_split_at_one(pq, hq, name) -> None:
    assert region(pq, hq) == name


def test_alpha_equals_pingouin(answers) -> None:
    import pingouin

    wide = item_scores(answers).query("pattern == 'P1'").pivot(index="participant", columns="item", values="score")
    items = list(FORM.items_of("HQ"))
    theirs, (low, high) = pingouin.cronbach_alpha(wide[items])
    row = consistency(item_scores(answers)).set_index(["pattern", "dimension"]).loc[("P1", "HQ")]
    assert row["alpha"] == pytest.approx(theirs, rel=1e-9)
    assert (row["alpha_low"], row["alpha_high"]) == pytest.approx((low, high), abs=6e-4)


def test_alpha_needs_three_participants_who_differ() -> None:
    three = consistency(item_scores(study(np.random.default_rng(), n=3).query("pattern == 'P1'")))
    assert three["alpha"].notna().any()
    assert set(three["n"]) == {3}
    few = consistency(item_scores(one_person(5)))
    assert few["alpha"].isna().all()
    assert set(few["note"]) == {"fewer than two items, or fewer than three participants who answered all items"}
    alike = pd.concat([one_person(5).assign(participant=f"P{n}") for n in range(4)])
    assert set(consistency(item_scores(alike))["note"]) == {"participants do not differ in this score"}


def test_missing_scores_are_counted() -> None:
    """P00 answered no item of PQ."""
    table = study(np.random.default_rng(), n=3).query("pattern == 'P1'")
    lost = (table["participant"] == "P00") & table["item"].isin(FORM.items_of("PQ"))
    found = summary(scores(table.assign(response=table["response"].where(~lost, "")))).set_index("dimension")
    assert found.loc[["PQ", "ATT"], ["n", "n_missing"]].to_numpy().tolist() == [[2, 1], [3, 0]]


def test_frequency_by_envelope_leaves_the_single_focus_out(scored) -> None:
    found = frequency_by_envelope(scored).set_index(["dimension", "Source"])
    assert len(found) == 5 * 3
    assert found.loc[("ATT", "frequency"), "ddof2"] == 11
    assert found.loc[("ATT", "frequency"), "p_unc"] < 0.01
    low = scored[scored["pattern"].isin(["P1", "P2", "P3"])].groupby("participant")["ATT"].mean()
    high = scored[scored["pattern"].isin(["P4", "P5", "P6"])].groupby("participant")["ATT"].mean()
    t = (high - low).mean() / ((high - low).std() / np.sqrt(12))
    assert found.loc[("ATT", "frequency"), "F"] == pytest.approx(t**2)


def test_every_pattern_is_compared_with_the_single_focus(scored) -> None:
    found = against_reference(scored).query("dimension == 'HQ'")
    assert found["a"].tolist() == ["P0"] * 6
    assert found["b"].tolist() == list(THESIS)
    own = scored.pivot(index="participant", columns="pattern", values="HQ")
    assert found["difference"].iloc[3] == pytest.approx((own["P4"] - own["P0"]).mean())
    assert (found["p_corr"] >= found["p_unc"]).all()


def test_participant_without_score_is_named_as_left_out(answers) -> None:
    gone = (answers["participant"] == "P03") & (answers["pattern"] == "P2") & answers["item"].str.startswith("PQ")
    found = frequency_by_envelope(scores(answers[~gone]))
    assert set(found[found["dimension"] == "PQ"]["left_out"]) == {"P03"}
    assert set(found[found["dimension"] == "ATT"]["left_out"]) == {""}
    assert found[found["dimension"] == "PQ"]["ddof2"].iloc[0] == 10


def test_identical_answers_have_note_without_f() -> None:
    answers = [one_person(4).assign(participant=f"P{n}", pattern=pattern) for n in range(4) for pattern in PATTERNS]
    found = frequency_by_envelope(scores(pd.concat(answers)))
    assert found["note"].str.contains("found the same value everywhere").all()


def test_refuses_patterns_that_are_not_there(scored) -> None:
    part = scored[scored["pattern"] != "P0"]
    with pytest.raises(InvalidParameter, match="pattern: found no P0 among P1, P2, P3, P4, P5, P6, expected it"):
        against_reference(part)
    with pytest.raises(InvalidParameter, match="pattern: found no column 'patern'; did you mean 'pattern'"):
        frequency_by_envelope(scored, pattern="patern")


def simulated(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, n: int = 3) -> Path:
    (tmp_path / "study.toml").write_text(text)
    output(capsys, "simulate", tmp_path / "study.toml", "--participants", n, "--seed", 1, "--out", tmp_path / "d")
    return tmp_path / "d"


def test_custom_form_is_scored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trials = read_trials(simulated(tmp_path, capsys, TUTORIAL + OWN_FORM, 2))
    rows = trials.rows[trials.rows["procedure"] == "mine"]
    answers = rows.pivot(index="participant", columns="item", values="response").astype(float)
    expected = ((2 * answers["A"] - 1) - (2 * answers["B"] - 1)) / 2
    assert ratings(trials)[0].scores["D"].tolist() == pytest.approx(expected.tolist(), abs=1e-12)


def test_damaged_custom_form_is_rejected_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(OWN_FORM.replace('"Bad", "Good"', '"Bad"'))
    with pytest.raises(InvalidFile, match=r"study.toml, forms.mine: items\[0\].poles.en: found "):
        forms_of(tmp_path)


WORDS = "variants.word.a.stimulus.frequency_hz = 60\nvariants.word.b.stimulus.frequency_hz = 240\n"
BEFORE = '\n[inquiries.before]\nform = "mine"\nafter = "start"\n'


@pytest.mark.parametrize("factor", ["", "words"])
def test_form_is_compared_within_conditions_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], factor: str
) -> None:
    text = TUTORIAL + OWN_FORM.replace('"mine"', '"mine"\nafter = "block"', 1)
    if factor:
        text = WORDS + text.replace("frequency_hz = [60, 240]", 'word = ["a", "b"]')
    data = simulated(tmp_path, capsys, text + BEFORE)
    assert "3 of 9 scores without a condition" in output(capsys, "analyse", data)
    [form] = ratings(read_trials(data))
    [name] = form.factors
    apart = form.scores[form.scores[name].isna()]
    assert (apart["n_answered"].tolist(), apart["D"].notna().tolist()) == ([2.0] * 3, [True] * 3)
    assert form.summary[["n", "n_missing"]].to_numpy().tolist() == [[3, 0]] * 2


def test_form_answered_twice_has_note_on_averaging(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = TUTORIAL + OWN_FORM.replace('"mine"', '"mine"\nafter = "session"', 1)
    text = output(capsys, "analyse", simulated(tmp_path, capsys, text + BEFORE))
    assert "3 of 3 scores: each averages answers given at several times" in text
