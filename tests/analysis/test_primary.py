"""Tests of the primary analysis and its checks in all output."""

import json
import re
from itertools import product
from pathlib import Path

import attrakdiff_answers
import numpy as np
import pandas as pd
import pytest
from command_line import output, refused
from scipy.stats import f_oneway

from tactometry.analysis.anova.group_means import group_table
from tactometry.analysis.anova.post_hoc import pairs
from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.analysis.outcomes.outcome import outcome
from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.report.methods import group_methods
from tactometry.analysis.report.page import figures_of
from tactometry.analysis.report.summary import summary
from tactometry.analysis.report.texts import outcome_sentences, primary_sentences
from tactometry.analysis.result import Analysis
from tactometry.cli.analyse import summary_text

FACTORS = ["force_n", "frequency_hz"]


def estimates(rng, n=8, interaction=0.0, n_below=0) -> pd.DataFrame:
    """Draw thresholds of two forces at three frequencies; the first `n_below` have bounds in the last cell."""
    keys = list(product([f"P{i}" for i in range(n)], (0.5, 2.0), (60, 120, 240)))
    table = pd.DataFrame(keys, columns=["participant", *FACTORS])
    own = dict(zip(table["participant"].unique(), rng.normal(0, 2, n), strict=True))
    effect = 20 - 0.02 * table["frequency_hz"] + interaction * (table["force_n"] > 1) * (table["frequency_hz"] == 240)
    table["threshold"] = effect + table["participant"].map(own) + rng.normal(0, 0.5, len(table))
    table = table.assign(status="ok", interval_low=table["threshold"] - 1, interval_high=table["threshold"] + 1)
    is_bound = table["participant"].isin([f"P{i}" for i in range(n_below)]) & (table["frequency_hz"] == 240)
    is_bound &= table["force_n"] > 1
    table.loc[is_bound, ["threshold", "interval_low"]] = np.nan
    return table.assign(status=np.where(is_bound, "threshold_below_range", "ok"))


def outcome_of(table: pd.DataFrame, **options):
    return outcome(table, FACTORS, "yes_no", "threshold", **options)


def test_anova_is_primary_for_complete_design() -> None:
    table = estimates(np.random.default_rng())
    found = outcome_of(table)
    assert (found.primary, found.notes) == ("anova", ())
    reason = "(by default: every participant has a value in every condition)"
    assert found.heading() == f"Primary analysis: repeated-measures analysis of variance {reason}"
    assert found.roles()[["role", "analysis"]].values.tolist() == [["primary", "anova"]]


@pytest.mark.parametrize("n_below", [0, 2])
def test_effects_are_same_without_pair_comparisons(n_below) -> None:
    table = estimates(np.random.default_rng(), n_below=n_below)
    whole, alone = outcome_of(table), outcome_of(table, compared=False)
    assert (len(whole.pairs), alone.pairs, alone.simple_pairs) == (2, {}, {})
    assert (alone.primary, alone.notes) == (whole.primary, whole.notes)
    pd.testing.assert_frame_equal(alone.effects, whole.effects)


def test_censored_anova_is_primary_with_bounds() -> None:
    table = estimates(np.random.default_rng(), n_below=2)
    found = outcome_of(table, bounds={"force_n": 3.0})
    assert (found.primary, found.effects.attrs["n"]) == ("censored_anova", 8)
    assert found.notes[0] == "the analysis with censored values treats 2 values as bounds"
    assert found.notes[1].startswith("the analysis of variance, a check, leaves out participant P0, participant P1, as")
    roles = found.roles().set_index("analysis")
    assert roles["role"].to_dict() == {"censored_anova": "primary", "anova": "check"}
    assert roles.loc["anova", "title"].endswith("without participant P0, participant P1")
    headings = list(outcome_sentences(found, "dB"))
    assert headings[0].startswith("Primary analysis: repeated-measures analysis of variance with censored values")
    checks = [heading for heading in headings if heading.startswith("Check: ")]
    assert checks == [f"Check: {roles.loc['anova', 'title']}"]
    assert set(found.pairs) == set(FACTORS)
    assert found.equivalence["force_n"]["n"].tolist() == [8]


def test_flat_cell_counts_as_interval() -> None:
    """One cell has both ends, the other only an upper end."""
    table = estimates(np.random.default_rng())
    rows = table.index[:2]
    table.loc[rows, "threshold"], table.loc[rows, "status"] = np.nan, "flat"
    table.loc[rows[0], "interval_low"] = np.nan
    found = outcome_of(table)
    assert found.primary == "censored_anova"
    assert found.notes[0] == "the analysis with censored values treats 1 value as a bound and 1 value as an interval"
    assert found.group[["n_below", "n_above", "n_interval", "n_missing"]].sum().tolist() == [0, 0, 2, 0]
    assert found.group["text"].str.contains("1 known by an interval only", regex=False).sum() == 2


@pytest.mark.parametrize("n_below", [0, 1])
def test_between_groups_design_has_anova_and_pairs(n_below) -> None:
    """Regression test: such designs had no analysis of variance."""
    table = estimates(np.random.default_rng(), n=9, n_below=n_below)
    table = table[(table["frequency_hz"] == 240) & (table["force_n"] > 1)]
    table = table.assign(group=["a", "b", "c"] * 3)
    found = outcome(table, ["group"], "yes_no", "threshold")
    assert found.primary == ("censored_anova" if n_below else "anova")
    assert "between-groups" in found.heading()
    assert len(found.group_pairs["group"]) == 3
    assert "Chi and Muller" not in group_methods([found], [], None)
    if not n_below:
        peer = f_oneway(*(part.astype(float) for _, part in table.groupby("group")["threshold"]))
        assert found.effects[["F", "p_unc"]].iloc[0].tolist() == pytest.approx([*peer], rel=1e-6)


def test_condition_left_out_by_model_has_no_mean() -> None:
    table = estimates(np.random.default_rng())
    table = table[table["frequency_hz"] < 240]
    lost = table["frequency_hz"] == 120
    found = outcome_of(table.assign(threshold=table["threshold"].where(~lost)))
    means = found.group.set_index("frequency_hz")["mean"].astype(float)
    assert found.primary == "censored_anova"
    assert means.loc[60].notna().all()
    assert means.loc[120].isna().all()


@pytest.mark.parametrize("named", ["anova", "censored_anova", "permutation", "mixed_model"])
def test_plan_names_primary_analysis(named) -> None:
    table = estimates(np.random.default_rng(), n_below=1)
    forces = table[["participant", *FACTORS]].assign(force_mean_n=1.1 * table["force_n"])
    found = outcome_of(table, primary=named, forces=forces)
    assert (found.primary, found.reason) == (named, "named in the analysis plan")
    assert found.roles()["role"].tolist().count("primary") == 1
    assert primary_sentences(found)
    left_out = any("the primary analysis leaves out participant P0" in note for note in found.notes)
    assert left_out == (named in ("anova", "permutation"))


@pytest.mark.parametrize("named", [None, "anova"])
def test_missing_anova_of_one_participant_is_noted_once(named) -> None:
    alone = estimates(np.random.default_rng()).query("participant == 'P1'")
    found = outcome_of(alone, primary=named)
    assert found.notes == ("no analysis of variance: fewer than 3 participants have a value in the same 2 conditions",)


def test_no_primary_analysis_if_the_named_one_is_unavailable() -> None:
    found = outcome_of(estimates(np.random.default_rng()), primary="mixed_model")
    assert (found.primary, primary_sentences(found)) == (None, [])
    assert found.notes == ("no primary analysis: linear mixed model (named in the analysis plan) has no result",)
    assert "Check: repeated-measures analysis of variance" in outcome_sentences(found, "dB")


def test_interaction_has_simple_effects() -> None:
    table = estimates(np.random.default_rng(), interaction=4.0)
    found = outcome_of(table)
    assert set(found.simple) == set(found.simple_pairs) == {("force_n", "frequency_hz"), ("frequency_hz", "force_n")}
    simple = found.simple["force_n", "frequency_hz"]
    assert simple["frequency_hz"].tolist() == [60, 120, 240]
    names = {"dependent": "threshold", "subject": "participant"}
    alone = repeated_measures(table[table["frequency_hz"] == 240], within="force_n", **names)
    assert simple["F"][2] == pytest.approx(alone["F"][0], rel=1e-9)
    assert simple["p_corr"].min() == pytest.approx(3 * simple["p_CM_corr"].min(), rel=1e-9)
    lines = outcome_sentences(found, "dB")["Simple effects of force_n at each frequency_hz"]
    assert lines[2].startswith("240 Hz: force_n, F(1, 7) = ")
    peer = pairs(table, factor="frequency_hz", by="force_n", **names)
    assert found.simple_pairs["frequency_hz", "force_n"]["p_corr"].tolist() == peer["p_corr"].tolist()
    assert len(peer) == 2 * 3


def test_censored_interaction_has_simple_effects_of_everyone() -> None:
    found = outcome_of(estimates(np.random.default_rng(), interaction=4.0, n_below=2))
    simple = found.simple["force_n", "frequency_hz"]
    assert simple["F"].notna().all()
    assert simple["ddof2"].round(6).tolist()[:2] == [7, 7]
    assert len(found.simple_pairs["force_n", "frequency_hz"]) == 3


@pytest.mark.parametrize("n_below", [0, 1])
def test_groups_that_interact_are_compared_at_each_condition(n_below) -> None:
    rng = np.random.default_rng()
    table = estimates(rng, n=10, n_below=n_below)
    table = table[table["force_n"] > 1].copy()
    table["hand"] = np.where(table["participant"].str[1].astype(int) < 5, "left", "right")
    table["threshold"] += 5.0 * (table["hand"] == "left") * (table["frequency_hz"] == 120)
    found = outcome(table, ["hand", "frequency_hz"], "yes_no", "threshold")
    assert set(found.simple) == {("frequency_hz", "hand")}
    assert set(found.simple_pairs) == {("frequency_hz", "hand"), ("hand", "frequency_hz")}
    assert found.simple_pairs["hand", "frequency_hz"]["n_a"].tolist() == [5, 5, 5]
    inside = found.simple_pairs["frequency_hz", "hand"]
    assert inside["hand"].tolist() == ["left"] * 3 + ["right"] * 3
    assert inside["df"].max() == pytest.approx(4)
    assert inside["p_corr"].min() == pytest.approx(6 * inside["p_unc"].min())  # all pairs of both groups together
    assert (inside["simultaneous_low"] < inside["difference_low"]).all()
    assert any("Welch's t(" in line for line in outcome_sentences(found, "dB")["Pairs of hand at each frequency_hz"])


def test_without_an_interaction_there_are_no_simple_effects() -> None:
    values = np.random.default_rng().normal(size=(6, 1)) + np.array([0, 1.0, 2, 3])
    values += 0.5 * np.array([[1, -1, -1, 1]]) * np.array([1, -1, 1, -1, 1, -1])[:, None]
    values += np.random.default_rng().normal(0, 0.1, (6, 2)).repeat(2, axis=1)
    keys = list(product([f"P{i}" for i in range(6)], (1.0, 2.0), (60, 120)))
    table = pd.DataFrame(keys, columns=["participant", *FACTORS]).assign(threshold=values.ravel(), status="ok")
    found = outcome_of(table)
    assert found.effects.set_index("Source").loc["force_n * frequency_hz", "p_CM_corr"] > 0.5
    assert (found.simple, found.simple_pairs) == ({}, {})


def test_within_interval_of_two_conditions_matches_difference() -> None:
    table = estimates(np.random.default_rng())
    two = table[(table["force_n"] > 1) & (table["frequency_hz"] > 60)]
    group = group_table(two, ["frequency_hz"])
    pair = pairs(two, dependent="threshold", factor="frequency_hz", subject="participant").iloc[0]
    half = (pair["difference_high"] - pair["difference_low"]) / 2
    for end, sign in (("low", -1), ("high", 1)):
        expected = group["mean"] + sign * half / np.sqrt(2)
        assert group[f"within_{end}"].to_numpy(dtype=float) == pytest.approx(expected.to_numpy(dtype=float), rel=1e-9)


def test_within_interval_ignores_shifts_between_participants() -> None:
    table = estimates(np.random.default_rng())
    shift = dict(zip(table["participant"].unique(), np.arange(8) * 100.0, strict=True))
    moved = table.assign(threshold=table["threshold"] + table["participant"].map(shift))
    one, other = (group_table(each, FACTORS) for each in (table, moved))
    reach = [each["within_high"].astype(float) - each["within_low"].astype(float) for each in (one, other)]
    assert reach[1].to_numpy() == pytest.approx(reach[0].to_numpy(), rel=1e-6)
    assert (other["mean_high"] - other["mean_low"]).min() > 10 * reach[1].max()


def test_incomplete_table_has_no_within_interval() -> None:
    group = group_table(estimates(np.random.default_rng(), n_below=1), FACTORS)
    assert group["within_low"].isna().all()
    assert group["text"].iloc[-1] == "of 8: 1 below the levels"


@pytest.fixture(scope="module")
def rated(tmp_path_factory):
    """AttrakDiff answers of seven participants to three custom patterns."""
    table = attrakdiff_answers.study(np.random.default_rng(), n=7, effect={"P1": 1.5})
    names = {"P0": "smooth", "P1": "rough", "P2": "sharp"}
    table = table[table["pattern"].isin(names)].assign(pattern=lambda t: t["pattern"].map(names))
    path = attrakdiff_answers.write(tmp_path_factory.mktemp("rated") / "answers.csv", table)
    return analyse(path, report=path.with_name("r.html"))


def test_plan_names_primary_analysis_of_questionnaires(rated) -> None:
    planned = analyse(rated.trials.path, plan=AnalysisPlan(primary="permutation"))
    for found, primary in ((rated, "anova"), (planned, "permutation")):
        assert {one.primary for form in found.forms for one in form.outcomes.values()} == {primary}


def test_custom_patterns_have_anova_and_pairs(rated) -> None:
    (form,) = rated.forms
    assert list(form.outcomes) == ["PQ", "HQI", "HQS", "ATT", "HQ"]
    effects = rated.tables["attrakdiff_anova"]
    assert effects.loc[effects["F"].notna(), "dimension"].tolist() == list(form.outcomes)
    compared = rated.tables["attrakdiff_pairs_pattern"]
    assert len(compared) == 5 * 3
    one = compared[compared["dimension"] == "PQ"]
    scores = rated.tables["attrakdiff_scores"]
    peer = pairs(scores, dependent="PQ", factor="pattern", subject="participant")
    assert one["p_corr"].tolist() == pytest.approx(peer["p_corr"].tolist())
    text = " ".join(summary_text(rated).split())
    for shown in (rated.report.read_text(), text):
        assert "Primary analysis: repeated-measures analysis of variance" in shown
    assert "PQ: pattern: F(" in text
    assert len(summary(rated)["questionnaire_statistics"]["attrakdiff"]["Pairs of pattern"]) == 15


def test_methods_of_questionnaire_name_its_analyses(rated) -> None:
    for text in ("Chi and Muller", "paired t-tests", "The primary analysis, chosen by a rule", "Cousineau"):
        assert text in rated.methods
    others = ("A censored value is known", "Welch", "permutation", "threshold", "Greenhouse-Geisser", "hierarchical")
    assert not [text for text in others if text in rated.methods]


def written(path, table: pd.DataFrame):
    """Write settings by adjustment, a trial each: the estimates are the settings."""
    rows = table.assign(session=1, study="s", block=1, trial=range(len(table)), procedure="a", level_unit="dB re 1 V")
    rows = rows.assign(level=rows["threshold"], task="adjustment", response=rows["threshold"], valid=1)
    first = ["participant", "session", "study", "block", "trial", *FACTORS, "procedure", "level", "level_unit"]
    rows[[*first, "task", "response", "valid"]].to_csv(path, index=False)
    return path


def test_command_names_primary_analysis(tmp_path, capsys) -> None:
    file = written(tmp_path / "t.csv", estimates(np.random.default_rng(), interaction=4.0))
    (found,) = json.loads(output(capsys, "analyse", file, "--report", tmp_path / "r.html", "--json"))["outcomes"]
    assert found["primary"]["analysis"] == "anova"
    assert found["primary"]["reason"] == "by default: every participant has a value in every condition"
    assert [row["Source"] for row in found["primary"]["effects"]] == [*FACTORS, "force_n * frequency_hz"]
    assert found["checks"] == []
    page = (tmp_path / "r.html").read_text()
    assert "<h3>Primary analysis: repeated-measures analysis of variance (by default" in page
    assert "Simple effects of force at each frequency" in page
    for name in ("analyses", "anova", "simple", "pairs"):
        assert list((tmp_path / "r_tables").glob(f"{name}_setting*.csv")), name


def test_plan_file_names_primary_analysis(tmp_path, capsys) -> None:
    file, plan = written(tmp_path / "t.csv", estimates(np.random.default_rng())), tmp_path / "plan.toml"
    plan.write_text('primary = "permutation"\n')
    (found,) = json.loads(output(capsys, "analyse", file, "--plan", plan, "--json"))["outcomes"]
    assert (found["primary"]["analysis"], len(found["checks"])) == ("permutation", 1)
    assert found["sentences"][0].startswith("force_n: permutation test with 128 sign changes")
    plan.write_text('primary = "anovas"\n')
    expected = "expected one of anova, censored_anova, permutation, mixed_model"
    assert refused(capsys, "analyse", file, "--plan", plan).endswith(f"{plan}, primary: found 'anovas', {expected}")


def test_methods_describe_only_what_ran(tmp_path) -> None:
    table = estimates(np.random.default_rng())
    alone, whole, incomplete = (
        analyse(written(tmp_path / f"{n}.csv", part)).methods
        for n, part in enumerate((table[table["participant"] == "P0"], table, table.drop(index=3)))
    )
    for absent in ("analysis of variance", "Holm", "t-intervals", "eta squared", "Welch"):
        assert absent not in alone
    assert "chosen by a rule that does not depend on any result" in whole
    assert ("pingouin" in whole, "Tobin" in whole, "statsmodels" in whole) == (True, False, False)
    assert "Tobin 1958" in incomplete
    assert "contrasts of this model" in incomplete


@pytest.fixture(scope="module")
def patterns(tmp_path_factory) -> Path:
    """Write AttrakDiff answers of six participants, who rate the high frequency better."""
    table = attrakdiff_answers.study(np.random.default_rng(), n=6, effect={"P4": 1.5, "P5": 1.5, "P6": 1.5})
    return attrakdiff_answers.write(tmp_path_factory.mktemp("patterns") / "answers.csv", table)


@pytest.fixture(scope="module")
def thesis_rated(patterns, tmp_path_factory) -> Analysis:
    return analyse(patterns, report=tmp_path_factory.mktemp("rated") / "r.html")


def test_a_study_of_a_questionnaire_alone_is_reported(thesis_rated) -> None:
    found, page = thesis_rated, thesis_rated.report.read_text()
    for text in ("AttrakDiff", "Portfolio", "Word pairs", "Patterns against P0", "Cronbach&#39;s alpha"):
        assert text in page
    assert (found.outcomes, found.warnings) == ((), ())
    (form,) = found.forms
    assert form.crossed.set_index(["dimension", "Source"]).loc[("HQ", "frequency"), "p_unc"] < 0.05
    assert list(form.cross().columns) == ["condition", "PQ", "HQI", "HQS", "ATT", "HQ"]
    assert {"attrakdiff_scores", "attrakdiff_portfolio", "attrakdiff_against_P0"} <= set(found.tables)
    assert summary(found)["questionnaires"]["attrakdiff"][0]["condition"] == "P0"


def test_word_pairs_are_grouped_by_frequency_and_envelope(thesis_rated) -> None:
    """Figures 5.9 to 5.13 of the thesis."""
    (form,) = thesis_rated.forms
    names = {figure.name.removeprefix("attrakdiff_") for figure in figures_of(thesis_rated)}
    by = {"word_pairs_by_frequency", "word_pairs_by_envelope", "word_pairs_low_frequency", "word_pairs_high_frequency"}
    assert names == by | {"scores", "portfolio", "frequency_by_envelope"}
    means = form.grouped.set_index(["of", "condition", "item"])["mean"]
    own = form.profile.set_index(["condition", "item"])["mean"]
    item = form.profile["item"].iloc[0]
    assert means["frequency", "high", item] == pytest.approx(np.mean([own[code, item] for code in ("P4", "P5", "P6")]))
    assert means["envelope", "sinc", item] == pytest.approx(np.mean([own[code, item] for code in ("P3", "P6")]))
    assert means["envelope", "P0", item] == own["P0", item]


@pytest.mark.parametrize("width", [80, 60])
def test_terminal_table_keeps_each_value_on_one_line(patterns, capsys, monkeypatch, width) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    lines = output(capsys, "analyse", patterns).splitlines()
    assert max(map(len, lines)) <= width
    rows = [line.split() for line in lines if line.startswith("│")]
    assert rows[0][1:4] == ["P0", "│", "PQ"]
    assert all(re.search(r"\[\S+, \S+\] \(n = 6\) │$", " ".join(row)) for row in rows)


def test_terminal_names_csv_when_table_is_too_wide(patterns, capsys, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    text = " ".join(output(capsys, "analyse", patterns).split())
    assert "n): too wide for 40 columns; see the tables of --report FILE.html (CSV)" in text


def test_the_terminal_shows_scores_and_comparisons(thesis_rated) -> None:
    text = summary_text(thesis_rated)
    assert "AttrakDiff (mean, 95 % interval between participants, n)" in text
    assert "frequency: F(1, 5)" in " ".join(text.split())
