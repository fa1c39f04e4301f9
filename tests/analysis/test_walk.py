"""Tests of hard cases in every fit, group statistic and the command.

Each has a number if the data determine one, else a status, and no library warns.
"""

import json
from itertools import product

import numpy as np
import pandas as pd
import pytest
from command_line import call
from hard_cases import exact_case
from scipy.special import ndtr
from soak import SOAK

from tactometry.analysis.anova.post_hoc import equivalence, pairs
from tactometry.analysis.anova.within_subjects import checks, permutation_test, repeated_measures
from tactometry.analysis.mixed_models.linear import mixed_model
from tactometry.analysis.threshold.fitting import METHODS, fit, fit_many
from tactometry.errors import InvalidParameter
from tactometry.psychometric import SHAPES

SEVEN = np.arange(1.0, 8.0)
RISING = [1, 2, 5, 10, 16, 18, 20]

# Levels, "yes" answers, trials, and the statuses that the answers leave open at a guess rate of 0
SETS = {
    "all correct": (SEVEN, [20] * 7, 20, {"threshold_below_range"}),
    "all chance": (SEVEN, [10] * 7, 20, {"flat"}),
    "all wrong": (SEVEN, [0] * 7, 20, {"threshold_above_range"}),
    "perfect step": (SEVEN, [0, 0, 0, 20, 20, 20, 20], 20, {"separated"}),
    "one level": ([3.0], [15], 20, {"too_few_levels"}),
    "one trial per level": (np.arange(1, 21), [0] * 7 + [1, 0, 0, 1, 0, 1] + [1] * 7, 1, {"ok"}),
    "a million trials per level": (SEVEN, [50_000 * k for k in RISING], 1_000_000, {"ok"}),
    "levels 1e-9 apart": (1e-9 * SEVEN, RISING, 20, {"ok"}),
    "levels 1e9 apart": (1e9 * SEVEN, RISING, 20, {"ok"}),
    "levels of 1e-12": (1e-12 * SEVEN, RISING, 20, {"ok"}),
    "huge offset, small spread": (1e6 + 1e-3 * SEVEN, RISING, 20, {"ok"}),
    "non-monotone": (SEVEN, [2, 8, 18, 20, 12, 5, 2], 20, {"non_monotone"}),
    "rows without trials": ([*SEVEN, 40, -3], [*RISING, 0, 0], [20] * 7 + [0, 0], {"ok"}),
    "duplicated levels": (np.repeat(SEVEN, 2), np.repeat(RISING, 2), 20, {"ok"}),
}
ESTIMATED = ("ok", "separated", "non_monotone", "too_few_levels")
"""Statuses that may come with a threshold."""


def is_honest(found, levels) -> bool:
    """Return True for a threshold within its interval and the levels, or a note without one."""
    if found.threshold is None:
        return bool(found.note) and found.width is None and found.function is None
    ends = [end for end in (found.interval_low, found.interval_high) if end is not None]
    assert np.isfinite([found.threshold, *ends]).all()
    inside = min(levels) <= found.threshold <= max(levels)
    return found.status in ESTIMATED and inside and sorted([found.threshold, *ends])[len(ends) // 2] == found.threshold


@pytest.mark.parametrize("case", list(SETS))
@pytest.mark.parametrize("method", METHODS)
def test_every_fit_has_number_or_status(method, case) -> None:
    """All families in the soak, else one of them by turns."""
    levels, k, n, statuses = SETS[case]
    turn = METHODS.index(method) + list(SETS).index(case)
    for shape in SHAPES if SOAK else [list(SHAPES)[turn % len(SHAPES)]]:
        options = {"shape": shape, "guess_rate": 0.0, "method": method}
        found = fit(levels, k, n, **options)
        wide = statuses | {"ok", "threshold_below_range", "threshold_above_range", "separated"}
        assert found.status in (statuses if shape in ("normal", "logistic") else wide), shape
        assert is_honest(found, levels)
    exact_case("every hard case by every method and family", against="a number or a status")


@pytest.mark.parametrize("method", METHODS)
def test_batch_of_hard_cases_equals_single_fits(method) -> None:
    columns: list[list[np.ndarray]] = [[], [], []]
    for levels, k, n, _ in SETS.values():
        for column, part in zip(columns, (levels, k, np.broadcast_to(n, len(levels))), strict=True):
            column.append(np.pad(np.asarray(part, dtype=float), (0, 20 - len(levels))))
    options = {"shape": "logistic", "guess_rate": 0.0, "method": method}
    together = fit_many(*columns, **options)
    for found, (levels, k, n, _) in zip(together, SETS.values(), strict=True):
        alone = fit(levels, k, n, **options)
        assert (found.status, found.threshold is None) == (alone.status, alone.threshold is None)
        if found.threshold is not None and found.interval_low is not None and found.interval_high is not None:
            reach = 0.01 * (found.interval_high - found.interval_low)
            assert found.threshold == pytest.approx(alone.threshold, abs=reach)
    exact_case("all hard cases in one stack", against="each alone")


# Statistics of a group
WITHIN = ["force", "hz"]
NAMES = {"dependent": "y", "subject": "who"}
STATISTICS = {
    "ANOVA": lambda t: repeated_measures(t, within=WITHIN, **NAMES)[["F", "p_unc", "np2", "ng2"]],
    "permutation": lambda t: permutation_test(t, within=WITHIN, **NAMES)[["F", "p_permutation"]],
    "checks": lambda t: checks(t, repeated_measures(t, within=WITHIN, **NAMES), within=WITHIN, **NAMES)[["text"]],
    "mixed model": lambda t: mixed_model(t, factors=WITHIN, **NAMES).terms[["F", "p"]],
    "pairs": lambda t: pairs(t, factor="hz", **NAMES)[["t", "p_corr", "status"]],
    "TOST": lambda t: equivalence(t, factor="hz", bound=1.0, **NAMES)[["difference", "p"]],
}
FACTORIAL = ("ANOVA", "permutation", "checks")
PAIRED = ("pairs", "TOST")


def group() -> pd.DataFrame:
    rng = np.random.default_rng(2)
    keys = list(product([f"P{i}" for i in range(6)], (0.5, 1.0), (60, 240, 480)))
    values = rng.normal(size=(6, 6)) + 0.5 * np.arange(6)[:, None] + np.array([0, 1, 0, 0, 1, 2.0])
    return pd.DataFrame(keys, columns=["who", *WITHIN]).assign(y=values.ravel())


WHOLE = group()
NO_ERROR = dict.fromkeys(("ANOVA", "permutation", "checks", "mixed model"), "zero_error")
NONE_WITHIN = dict.fromkeys(("ANOVA", "permutation", "checks"), "no_variance_within") | {"mixed model": "zero_error"}
SAME = dict.fromkeys(("ANOVA", "permutation", "checks", "mixed model"), "constant")
TABLES = {
    "identical participants": (WHOLE.assign(y=np.tile([1, 2, 3, 4, 6, 5.0], 6)), NO_ERROR),
    "no variance within participants": (WHOLE.assign(y=np.repeat(np.arange(6.0), 6)), NONE_WITHIN),
    "the same value everywhere": (WHOLE.assign(y=3.0), SAME),
    "two participants": (WHOLE[WHOLE["who"] < "P2"], dict.fromkeys((*FACTORIAL, *PAIRED), "too_few_participants")),
    "one participant": (WHOLE[WHOLE["who"] < "P1"], dict.fromkeys(STATISTICS, "too_few_participants")),
    "a missing cell": (WHOLE.drop(index=7), dict.fromkeys(FACTORIAL, "missing_cell")),
    "a participant without a level": (
        WHOLE[(WHOLE["who"] != "P1") | (WHOLE["hz"] != 240)],
        dict.fromkeys((*FACTORIAL, *PAIRED), "missing_cell"),
    ),
    "one level": (WHOLE[WHOLE["hz"] == 60], dict.fromkeys(STATISTICS, "one_level")),
    "NaN": (WHOLE.assign(y=WHOLE["y"].where(WHOLE.index != 5)), dict.fromkeys(STATISTICS, "not_finite")),
    "text": (
        WHOLE.assign(y=WHOLE["y"].astype(object).where(WHOLE.index != 5, "loud")),
        dict.fromkeys(STATISTICS, "not_finite"),
    ),
    "no row": (WHOLE.iloc[:0], dict.fromkeys(STATISTICS, "no_data")),
    "values of 1e-12": (WHOLE.assign(y=1e-12 * WHOLE["y"]), {}),
    "1e9 away": (WHOLE.assign(y=1e9 + WHOLE["y"]), {}),
}


@pytest.mark.parametrize("case", list(TABLES))
@pytest.mark.parametrize("statistic", list(STATISTICS))
def test_every_group_statistic_has_number_or_status(statistic, case) -> None:
    table, statuses = TABLES[case]
    if statistic in statuses:
        with pytest.raises(InvalidParameter, match=r"found .*expected") as refusal:
            STATISTICS[statistic](table)
        assert getattr(refusal.value, "status", "too_few_participants") == statuses[statistic]
    else:
        found = STATISTICS[statistic](table)
        tested = found[found["status"] == "ok"] if "status" in found else found
        assert np.isfinite(tested.select_dtypes("number")).all(axis=None)
    exact_case("every hard case by every statistic of a group", against="a number or a status")


def test_means_over_incomplete_cells_have_note() -> None:
    found = pairs(WHOLE.drop(index=7), factor="hz", **NAMES)
    assert found.attrs["notes"] == ["several values of one participant in one cell were averaged, 1 to 2 per cell"]


# The command
HEAD = "participant,trial,hz,procedure,level,task,response,correct,target"
TASKS = ("yes_no", "forced_choice", "comparison")


def rising(levels=SEVEN, n=12):
    """Return answers of four participants in two conditions, with thresholds near the middle."""

    def drawn(place, floor, rng):
        spacing = levels[1] - levels[0]
        chance = floor + (0.98 - floor) * ndtr((levels - np.mean(levels)) / spacing - 0.25 * place)
        return list(zip(levels, rng.binomial(n, chance), [n] * len(levels), strict=True))

    return drawn


def constant(k, levels=SEVEN, n=12):
    return lambda place, floor, rng: [
        (x, each, n) for x, each in zip(levels, np.broadcast_to(k, len(levels)), strict=True)
    ]


STUDIES = {
    "all correct": (constant(12), 4, "threshold_below_range"),
    "all chance": (constant(6), 4, ("flat", "threshold_above_range", "flat")),
    "perfect step": (lambda place, floor, rng: [(x, 10 if x > 4 else 10 * floor, 10) for x in SEVEN], 4, "separated"),
    "one level": (constant(6, [4.0]), 4, "too_few_levels"),
    "levels 1e-9 apart": (rising(1e-9 * SEVEN), 4, None),
    "levels 1e9 apart": (rising(1e9 * SEVEN), 4, None),
    "levels of 1e-12": (rising(1e-12 * SEVEN), 4, None),
    "huge offset, small spread": (rising(1e6 + 1e-3 * SEVEN), 4, None),
    "falling": (constant([12, 11, 10, 8, 4, 2, 0]), 4, "non_monotone"),
    "duplicated levels": (lambda *a: [*rising(n=6)(*a), *rising(n=6)(*a)], 4, None),
    "two participants": (rising(), 2, None),
    "one participant": (rising(), 1, None),
}


def written(path, drawn, n, task, without=()):
    rng, lines = np.random.default_rng(3), [HEAD]
    floor = 0.5 if task == "forced_choice" else 0.0
    for place, hz in product(range(n), (60, 240)):
        if (place, hz) in without:
            continue
        for level, k, trials in drawn(place, floor, rng):
            for trial in range(trials):
                felt, target = int(trial < k), 1 + trial % 2
                tail = f"{target if felt else 3 - target},{felt},{target}" if floor else f"{felt},,"
                lines.append(f"P{place},{trial},{hz},c,{float(level)!r},{task},{tail}")
    path.write_text("\n".join(lines))
    return path


def analysed(capsys, file, *options) -> dict:
    code, errors, out = call(capsys, "analyse", file, "--json", *options)
    assert (code, errors) == (0, "")
    return json.loads(out)


@pytest.mark.parametrize("case", list(STUDIES))
def test_command_reports_status_of_every_hard_case(tmp_path, capsys, case) -> None:
    """Every task, with its report, in the soak; else one of them by turns."""
    drawn, n, status = STUDIES[case]
    turn = list(STUDIES).index(case) % len(TASKS)
    for task in TASKS if SOAK else TASKS[turn : turn + 1]:
        file = written(tmp_path / f"{task}.csv", drawn, n, task)
        found = analysed(capsys, file, *(["--report", tmp_path / f"{task}.html"] if SOAK else []))
        expected = status[TASKS.index(task)] if isinstance(status, tuple) else status
        statuses = {row["status"] for row in found["thresholds"]}
        assert statuses == {expected} if expected else "ok" in statuses
        if expected in ("threshold_below_range", "threshold_above_range", "flat", "too_few_levels"):
            assert {row["threshold"] for row in found["thresholds"]} == {None}
            assert {row["mean"] for row in found["outcomes"][0]["group"]} == {None}
            assert found["hierarchical"] == [] or found["hierarchical"][0]["status"] is None
            assert found["warnings"]
        if (case, task) == ("perfect step", "comparison"):
            (hierarchical,) = found["hierarchical"]
            assert [row["width"] for row in hierarchical["conditions"]] == [None, None]
            assert not any("Wald" in sentence for sentence in hierarchical["sentences"])
    exact_case("every hard case by the command", against="a number or a status")


def test_missing_cell_is_named_in_first_warning(tmp_path, capsys) -> None:
    found = analysed(capsys, written(tmp_path / "t.csv", rising(), 4, "comparison", without=[(1, 240)]))
    assert found["warnings"][0] == "1 of 8 cells of comparison have no valid trial (P1 hz 240)"
    outcome = found["outcomes"][0]
    assert outcome["notes"][0] == "the analysis with censored values treats 1 value as missing at random"
    assert "leaves out participant P1" in outcome["notes"][1]
    assert outcome["primary"]["analysis"] == "censored_anova"
    (check,) = outcome["checks"]
    assert check == "repeated-measures analysis of variance of the largest complete subset, without participant P1"


def test_identical_participants_have_mean_without_interval(tmp_path, capsys) -> None:
    file = written(tmp_path / "t.csv", constant([0, 1, 3, 6, 9, 11, 12]), 4, "comparison")
    outcome = analysed(capsys, file)["outcomes"][0]
    first = outcome["group"][0]
    assert first["text"] == "4.00 (n = 4, all alike)"
    assert (first["sd"], first["mean_low"], first["mean_high"]) == (0.0, None, None)
    assert outcome["status"] == "constant"
