"""`tactometry validate-method`: departures, repeatability, resuming, and docs/explanation/validated.md."""

import copy
import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from command_line import call, output, refused, status
from places import DOCS
from scipy.stats import norm

from tactometry.analysis.anova.design import DesignStatus, UndefinedStatistic
from tactometry.experiments.bias_study.comparisons import PEOPLE
from tactometry.experiments.validation.check import ESTIMATES, RANKS, TESTS, summary
from tactometry.experiments.validation.checks import CHECKS, check_of
from tactometry.experiments.validation.checks.calibration import rank
from tactometry.experiments.validation.page import departures, page, shown
from tactometry.experiments.validation.run import Chunk, Validated, Validation, validate

SMALL = Validation(seed=3, n_rounds=2, checks=("comparisons",))
PAGE, PAGE_SEED, PAGE_ROUNDS = DOCS / "explanation" / "validated.md", 1, 20


def tables(root):
    return {path.name: path.read_bytes() for path in root.glob("*.csv")}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    root = tmp_path_factory.mktemp("whole") / "v"
    return root, validate(SMALL, root)


# --- what a table says of outcomes


def of_estimates(estimate, reach, n=2000):
    truth = np.random.default_rng(1).standard_normal(n)
    found = truth + estimate * np.random.default_rng(2).standard_normal(n)
    table = pd.DataFrame({"truth": truth, "estimate": found, "low": found - reach, "high": found + reach})
    return summary(ESTIMATES, table.assign(fit="a"), ("fit",)).iloc[0]


@pytest.mark.parametrize(("part", "verdict"), [(0.8, "too few"), (1.0, ""), (1.2, "too many")])
def test_intervals_of_wrong_length_depart(part, verdict):
    row = of_estimates(2.0, part * 2.0 * norm.ppf(0.975))
    assert row["verdict"] == verdict
    assert row["width"] == pytest.approx(2 * part * 2.0 * norm.ppf(0.975))


def test_bias_is_that_of_sets_with_a_value():
    found = {"estimate": [1.0, 2, 3, None], "low": [0.0, 0, 0, 1], "high": [4.0, 4, 4, None]}
    table = pd.DataFrame({"truth": 0.0, **found})
    row = summary(ESTIMATES, table.assign(fit="a"), ("fit",)).iloc[0]
    assert (row["sets"], row["none"], row["n"], row["share"], row["bounds"]) == (4, 0.25, 3, 1.0, 0.0)
    assert (row["bias"], row["error_sd"], row["bias_se"]) == pytest.approx((2.0, 1.0, 1 / np.sqrt(3)))


@pytest.mark.parametrize(("power", "verdict"), [(1.0, ""), (0.5, "too many"), (2.0, "too few")])
def test_tests_with_wrong_error_rate_depart(power, verdict):
    p = np.random.default_rng(5).random(4000) ** (1 / power)
    row = summary(TESTS, pd.DataFrame({"effect": 0.0, "p": p, "test": "t"}), ("test",)).iloc[0]
    assert row["verdict"] == verdict


def test_power_has_no_verdict():
    row = summary(TESTS, pd.DataFrame({"effect": [1.0] * 100, "p": 0.0, "test": "t"}), ("test",)).iloc[0]
    assert (row["share"], row["verdict"]) == (1.0, "")


@pytest.mark.parametrize(("posterior_sd", "shift", "verdict"), [(1, 0, ""), (0.7, 0, "not"), (1, 0.3, "not")])
def test_ranks_are_uniform_in_the_right_posterior(posterior_sd, shift, verdict):
    """Truth and error have variance 1; `posterior_sd` scales the posterior."""
    rng = np.random.default_rng(11)
    truth = rng.standard_normal(4000)
    centre = (truth + rng.standard_normal(4000)) / 2 + shift
    quantiles = [
        norm.ppf([0.5 - s / 2, 0.5, 0.5 + s / 2], 0, posterior_sd / np.sqrt(2)) for s in np.arange(0.1, 0.95, 0.1)
    ]
    places = centre[:, None, None] + np.array(quantiles).T
    ranks = rank(truth, places, rng)
    row = summary(RANKS, pd.DataFrame({"rank": ranks, "posterior": "a"}), ("posterior",)).iloc[0]
    assert row["verdict"].startswith(verdict)
    assert bool(row["verdict"]) == bool(verdict)
    assert sum(row[f"bin_{place:02d}"] for place in range(1, 21)) == 4000


@pytest.mark.parametrize("name", CHECKS)
def test_columns_of_outcomes_replace_no_key(name):
    check = check_of(name)
    outcome = dict.fromkeys(("truth", "estimate", "low", "high", "effect", "p", "rank"), 0.5)
    assert not set(check.keys) & set(check.kind.row(pd.DataFrame([outcome] * 2)))


def test_rows_of_comparisons_name_their_people(whole):
    check, (_, found) = check_of("comparisons"), whole
    rows = found.tables["comparisons"]
    assert len(rows[["sd", "n_trials", "lapse_rate"]].drop_duplicates()) == len(check.settings)
    assert set(rows["sd"]) == {person.sd for person in PEOPLE}


# --- a run


def test_interrupted_command_states_how_to_resume(tmp_path, capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("tactometry.cli.validate_method.validate", interrupted)
    code, said, _ = call(capsys, "validate-method", "--out", tmp_path / "v")
    assert (code, said.strip()) == (130, "tactometry: interrupted; recorded data are safe: continue with --resume")


def test_tables_do_not_depend_on_processes(whole, tmp_path):
    root, _ = whole
    words = ("--check", "comparisons", "--rounds", "2", "--seed", "3", "--jobs", "2")
    assert status("validate-method", "--out", tmp_path / "v", *words) == 0
    assert tables(tmp_path / "v") == tables(root)
    assert {path.suffix for path in (tmp_path / "v" / "validated").iterdir()} == {".png", ".svg"}


def test_interrupted_run_resumes_with_more_rounds(whole, tmp_path):
    root, _ = whole
    chunks = SMALL.chunks

    def dies(function, jobs):
        for job in list(jobs)[:3]:
            yield function(job)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        validate(replace(SMALL, n_rounds=1), tmp_path / "v", spread=dies)
    assert [chunk.path(tmp_path / "v").exists() for chunk in chunks[:4]] == [True, True, True, False]
    made = []
    validate(SMALL, tmp_path / "v", resume=True, tell=lambda found, n: (made.append(each) or each for each in found))
    assert made == [chunk.path(tmp_path / "v") for chunk in chunks[3:]]
    assert tables(tmp_path / "v") == tables(root)


def test_chunks_have_separate_random_numbers():
    settings = list(check_of("comparisons").settings)[:2]
    other = [Chunk("comparisons", setting, number) for setting in settings for number in (0, 1)]
    drawn = [each.simulated(1)["estimate"].to_numpy() for each in other]
    drawn.append(other[0].simulated(2)["estimate"].to_numpy())
    assert len({values.tobytes() for values in drawn}) == len(drawn)
    assert drawn[0].tobytes() == other[0].simulated(1)["estimate"].to_numpy().tobytes()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--check", "comparison"], "tactometry: --check: found 'comparison', expected one of"),
        (["--rounds", "0"], "tactometry: --rounds: found 0, expected at least 1"),
        (["--seed", "-1"], "tactometry: --seed: found -1, expected a whole number, at least 0"),
        (["--jobs", "0"], "--jobs: found 0, expected at least 1"),
    ],
)
def test_invalid_options_are_refused(options, expected, capsys, tmp_path):
    assert expected in refused(capsys, "validate-method", "--out", tmp_path / "v", *options)
    assert not (tmp_path / "v").exists()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--seed", "3"], "found this validation, expected an empty folder; continue with --resume"),
        (["--resume"], "found seed 3, expected 1"),
    ],
)
def test_folder_of_another_run_is_unchanged(options, expected, whole, capsys):
    root, _ = whole
    before = tables(root)
    assert expected in refused(capsys, "validate-method", "--out", root, "--check", "comparisons", *options)
    assert tables(root) == before


def test_errors_can_be_copied_from_workers():
    error = copy.copy(UndefinedStatistic("a sentence", DesignStatus.NO_DATA))
    assert (str(error), error.status) == ("a sentence", DesignStatus.NO_DATA)


# --- every check, and the page


@pytest.mark.slow
@pytest.mark.parametrize("name", CHECKS)
def test_every_setting_has_outcomes_of_its_kind(name):
    check = check_of(name)
    for simulate in check.settings.values():
        outcomes = simulate(2, np.random.default_rng(1))
        assert {*check.keys, *check.kind.columns} <= set(outcomes.columns)
        assert np.isfinite(outcomes[list(check.kind.columns)].to_numpy(float)).any()


def test_departures_are_listed_with_their_reason(whole):
    _, found = whole
    table = found.tables["comparisons"].copy()
    assert departures(table).empty
    assert "No share differs significantly from the stated value." in page(found)
    table.loc[0, "verdict"] = "too few"
    wrong = page(Validated(SMALL, {"comparisons": table}, found.seconds))
    assert "- *equality*, too few in 1 of the rows: same reason as for the difference." in wrong


def test_departure_of_all_rows_together_is_listed(whole):
    """A share of 94 % may be chance in one row of 1000 sets, but not in all rows together."""
    _, found = whole
    table = found.tables["comparisons"].assign(n=1000, share=0.94, stated=0.95, verdict="")
    said = page(Validated(SMALL, {"comparisons": table}, found.seconds))
    assert "- *equality*: 94.0 % over all rows together, 95 % stated: same reason as for the difference." in said
    assert "over all rows" not in page(Validated(SMALL, {"comparisons": table.assign(share=0.95)}, found.seconds))


def test_page_of_the_docs_is_that_of_the_command():
    """One setting is computed in all its rounds; `make validated` runs all."""
    text = PAGE.read_text("utf-8")
    assert f"--rounds {PAGE_ROUNDS} --seed {PAGE_SEED}" in text
    assert [f"## {check_of(name).title}" in text for name in CHECKS] == [True] * len(CHECKS)
    check, setting = check_of("comparisons"), next(iter(check_of("comparisons").settings))
    chunks = [Chunk("comparisons", setting, number).simulated(PAGE_SEED) for number in range(PAGE_ROUNDS)]
    table = summary(check.kind, pd.concat(chunks, ignore_index=True), check.keys)
    for row in table.to_dict("records"):
        cells = [row["quantity"], *(f" {shown(name, row)} |" for name in ("bias", "error_sd", "share", "width"))]
        assert any(all(cell in line for cell in cells) for line in text.splitlines())
    for figure in (check_of(name).figure for name in CHECKS):
        assert not figure or (PAGE.parent / "validated" / f"{figure}.svg").exists()


def test_command_lists_departures(whole, capsys):
    root, found = whole
    words = ("validate-method", "--out", root, "--check", "comparisons", "--seed", "3", "--rounds", "2", "--resume")
    assert output(capsys, *words).startswith("comparisons: 32 rows, 0 outside the stated bounds")
    rows = json.loads(output(capsys, *words, "--json"))["tables"]["comparisons"]
    assert len(rows) == len(found.tables["comparisons"])
