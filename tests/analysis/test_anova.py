"""Tests of repeated-measures ANOVA: published values and invariances."""

import math
import re

import numpy as np
import pandas as pd
import pytest
from hard_cases import exact_case, hard_case
from published_design import PUBLISHED, WITHIN, long_table

from tactometry.analysis.anova.bounded_design import largest_complete
from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.errors import InvalidParameter


@pytest.fixture
def published() -> pd.DataFrame:
    return long_table(np.array(PUBLISHED.split(), dtype=float).reshape(8, 12))


def analysed(table: pd.DataFrame, within=WITHIN) -> pd.DataFrame:
    return repeated_measures(table, dependent="y", within=within, subject="subject").set_index("Source")


@pytest.mark.parametrize(
    ("effect", "ss", "f", "p", "w", "epsilon", "p_corrected", "ng2"),
    [
        ("force", 29.930990, 38.121061, 2.162874e-6, 0.888157, 0.899408, 6.290984e-6, 0.105953),
        ("freq", 778.992500, 625.427670, 1.093439e-20, 0.489410, 0.665974, 2.097376e-14, 0.755163),
        ("force * freq", 5.342344, 1.980857, 0.09005187, 0.080312, 0.611773, 0.1319352, 0.020714),
    ],
)
def test_published_two_way_analysis(published, effect, ss, f, p, w, epsilon, p_corrected, ng2) -> None:
    row = analysed(published).loc[effect]
    assert row["SS"] == pytest.approx(ss, rel=1e-7)
    assert row["F"] == pytest.approx(f, rel=1e-6)
    assert row["p_unc"] == pytest.approx(p, rel=1e-6)
    assert row["W_spher"] == pytest.approx(w, abs=1e-6)
    assert row["eps"] == pytest.approx(epsilon, abs=1e-6)
    assert row["p_GG_corr"] == pytest.approx(p_corrected, rel=1e-5)
    assert row["ng2"] == pytest.approx(ng2, abs=1e-6)


@pytest.mark.parametrize(("scale", "offset"), [(1.0, 1e9), (1e-12, 0.0), (1e12, -3.0), (1e-300, 0.0), (1e300, 0.0)])
@pytest.mark.parametrize("within", [WITHIN, ["freq"]])
def test_anova_ignores_scale_and_offset(published, within, scale: float, offset: float) -> None:
    moved = published.assign(y=published["y"] * scale + offset)
    one, other = (analysed(table, within).drop(index="Error", errors="ignore") for table in (published, moved))
    hard_case("ANOVA of values of 1e-299 to 1e301, and 1e9 away: F", other["F"], one["F"], 1e-4, against="values of 1")
    for name in ("F", "p_unc", "p_CM_corr", "np2_low", "ng2", "W_spher"):
        expected = pytest.approx(one[name].to_numpy(), rel=1e-3 if offset else 1e-9, nan_ok=True)
        assert other[name].to_numpy() == expected
    with np.errstate(over="ignore"):
        ss = one["SS"].to_numpy() * scale * scale
    assert other["SS"].to_numpy() == pytest.approx(ss, rel=1e-4 if offset else 1e-9)


def test_two_levels_have_the_columns_of_more(published) -> None:
    two = repeated_measures(published[published["freq"] < 200], dependent="y", within="freq", subject="subject")
    more = repeated_measures(published, dependent="y", within="freq", subject="subject")
    assert list(two.columns) == list(more.columns)
    assert two.loc[0, ["p_GG_corr", "p_HF_corr", "p_CM_corr"]].tolist() == [two.loc[0, "p_unc"]] * 3
    crossed = analysed(published).reset_index()
    assert set(crossed.columns) == set(more.columns) - {"DF"}


def test_effect_has_no_f_when_error_is_zero() -> None:
    """The other effects have one."""
    rng = np.random.default_rng()
    values = np.arange(6.0)[:, None, None] + np.array([0.0, 3.0])[None, :, None] + rng.normal(size=(6, 1, 3))
    table = long_table(values, forces=(1, 2), frequencies=(60, 120, 240))
    found = repeated_measures(table, dependent="y", within=WITHIN, subject="subject")
    assert found["F"].notna().tolist() == [False, True, False]
    assert found.attrs["notes"] == [
        f"{name}: found the same differences in all participants, so the error is 0 and F is undefined"
        for name in ("force", "force * freq")
    ]
    assert found["np2"].isna().tolist() == [True, False, True]
    exact_case("one effect without error beside one with: ANOVA", against="a note")


def test_anova_ignores_row_order_and_participant_names(published) -> None:
    shuffled = published.sample(frac=1.0, random_state=np.random.default_rng().integers(2**31))
    renamed = shuffled.assign(subject=shuffled["subject"].map(lambda code: f"{code[::-1]} x"))
    assert analysed(renamed)["F"].to_numpy() == pytest.approx(analysed(published)["F"].to_numpy(), rel=1e-9)


def test_names_with_spaces_and_unused_categories_are_harmless(published) -> None:
    table = published.rename(columns={"freq": "the frequency"})
    table["force"] = pd.Categorical(table["force"], categories=[0.5, 1, 2, 9])
    found = repeated_measures(table, dependent="y", within=["force", "the frequency"], subject="subject")
    assert found["F"].to_numpy() == pytest.approx(analysed(published)["F"].to_numpy(), rel=1e-9)


def test_several_values_per_cell_are_averaged_with_note(published) -> None:
    twice = pd.concat([published.assign(y=published["y"] + d) for d in (-1, 1)])
    found = repeated_measures(twice, dependent="y", within=WITHIN, subject="subject")
    assert found.attrs["notes"] == ["several values of one participant in one cell were averaged"]
    assert found["F"].to_numpy() == pytest.approx(analysed(published)["F"].to_numpy(), rel=1e-9)


def with_value(table: pd.DataFrame, row: int, value: object) -> pd.DataFrame:
    changed = table.astype({"y": object})
    changed.loc[row, "y"] = value
    return changed


SUBJECTS = np.arange(8.0)[:, None]
CONDITIONS = np.arange(12.0)


NOT_FINITE = "(subject = P1, force = {}, freq = {}), expected a finite number; remove the participant or the condition"
ALL_ALIKE = "y: found the same differences in all participants, expected some error, without which F is undefined"
HOLE = (
    "y: found no value for subject = {}, expected one in every cell; remove the participant or the condition, or fit "
)
HOLE += "a mixed model"
NONE_WITHIN = "y: found no difference between the conditions of any participant, expected differences, without which F "
NONE_WITHIN += "is undefined"
FEW = "expected at least 3 to compare"
UNSORTED = "freq: found values that cannot be sorted (list), expected numbers or text"
NO_NAME = "found nothing, expected the name of a participant or a condition; remove the row"


@pytest.mark.parametrize(
    ("make", "message", "status"),
    [
        (lambda t: t.assign(y=3.25), "y: found the same value everywhere, expected values that differ", "constant"),
        (lambda t: t.assign(y=-3e9), "y: found the same value everywhere, expected values that differ", "constant"),
        (lambda t: t.assign(y=np.repeat(np.arange(8.0), 12)), NONE_WITHIN, "no_variance_within"),
        (lambda t: t.assign(y=(SUBJECTS + CONDITIONS**2).ravel()), ALL_ALIKE, "zero_error"),
        (lambda t: t.assign(y=(0 * SUBJECTS + CONDITIONS**2).ravel()), ALL_ALIKE, "zero_error"),
        (lambda t: t.drop(index=17), HOLE.format("P2, force = 1.0, freq = 120 (1 missing cell: P2)"), "missing_cell"),
        (
            lambda t: t.query("not (subject == 'P3' and freq == 480)"),
            HOLE.format("P3, force = 0.5, freq = 480 (3 missing cells: P3)"),
            "missing_cell",
        ),
        (lambda t: t[t["subject"] == "P1"], f"subject: found 1 participant, {FEW}", "too_few_participants"),
        (lambda t: t[t["subject"] < "P3"], f"subject: found 2 participants, {FEW}", "too_few_participants"),
        (lambda t: t[t["freq"] == 60], "freq: found 1 value, expected at least 2 to compare", "one_level"),
        (lambda t: t.iloc[:0], "table: found no row, expected values to compare", "no_data"),
        (lambda t: with_value(t, 5, math.nan), f"y, row 5: found nan {NOT_FINITE.format(1.0, 120)}", "not_finite"),
        (lambda t: with_value(t, 5, -math.inf), f"y, row 5: found -inf {NOT_FINITE.format(1.0, 120)}", "not_finite"),
        (lambda t: with_value(t, 0, "loud"), f"y, row 0: found loud {NOT_FINITE.format(0.5, 60)}", "not_finite"),
        (lambda t: t.assign(subject=t["subject"].where(t.index != 24)), f"subject, row 24: {NO_NAME}", "no_name"),
        (lambda t: t.assign(freq=t["freq"].where(t.index != 7)), f"freq, row 7: {NO_NAME}", "no_name"),
        (lambda t: t.assign(freq=[[x] for x in t["freq"]]), UNSORTED, None),
        (
            lambda t: t.rename(columns={"freq": "frec"}),
            "repeated_measures: found no column 'freq'; did you mean 'frec'?",
            None,
        ),
    ],
)
def test_undefined_analysis_is_refused_with_its_status(published, make, message: str, status) -> None:
    with pytest.raises(InvalidParameter, match=f"^{re.escape(message)}$") as refusal:
        analysed(make(published))
    assert getattr(refusal.value, "status", None) == status
    exact_case("differences without error, one value, holes: ANOVA", against="one sentence")


def test_refuses_four_factors(published) -> None:
    table = published.assign(third=1, fourth=2)
    with pytest.raises(InvalidParameter, match="expected one to three different factors"):
        analysed(table, [*WITHIN, "third", "fourth"])


@pytest.mark.parametrize(
    ("is_kept", "within", "left_out", "n_rows"),
    [
        (lambda t: t["y"] > 0, ("force", "freq"), (), 96),
        (lambda t: t.index != 17, ("force", "freq"), ("participant P2",), 84),
        (lambda t: t["freq"] != 480, ("force", "freq"), ("freq = 480",), 72),
        (lambda t: t["force"] == 1, ("freq",), ("force = 0.5", "force = 2.0"), 32),
    ],
    ids=["complete", "participant", "condition", "factor"],
)
def test_largest_complete_part_drops_what_is_missing(published, is_kept, within, left_out, n_rows) -> None:
    table = published.assign(y=published["y"].where(is_kept(published)))
    part = largest_complete(table, dependent="y", within=WITHIN, subject="subject")
    assert (part.within, part.left_out, len(part.table)) == (within, left_out, n_rows)


def complete_part(sides):
    """Return the largest complete part of participants with values at these sides."""
    rows = [(f"P{n}", side, 1.0 if side in known else None) for n, known in enumerate(sides, 1) for side in "abc"]
    table = pd.DataFrame(rows, columns=["participant", "side", "threshold"])
    return largest_complete(table, dependent="threshold", within=["side"], subject="participant")


@pytest.mark.parametrize(("n_complete", "exists"), [(1, False), (2, False), (3, True)])
def test_complete_part_has_at_least_three_participants(n_complete, exists) -> None:
    assert (complete_part(["ab"] * n_complete + ["a"] * (4 - n_complete)) is not None) == exists


@pytest.mark.parametrize(
    ("sides", "left_out"),
    [
        (["abc"] * 4 + ["ab"] * 2, ("side = c",)),
        (["ab"] * 3 + ["bc"] * 3, ("participant P4", "participant P5", "participant P6", "side = c")),
    ],
    ids=["more participants", "earlier levels"],
)
def test_tied_complete_parts_are_resolved(sides, left_out) -> None:
    assert complete_part(sides).left_out == left_out
