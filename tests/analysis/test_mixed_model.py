"""Tests of linear mixed models: published values and closed forms."""

import re
import warnings

import numpy as np
import pandas as pd
import pytest
from designs import drawn, long_table as any_table
from hard_cases import hard_case
from published_design import PUBLISHED, WITHIN, long_table

from tactometry.analysis.anova.design import WithinDesign, effects
from tactometry.analysis.anova.split_plot import mixed_anova
from tactometry.analysis.anova.within_subjects import repeated_measures
from tactometry.analysis.mixed_models.linear import ModelStatus, mixed_model
from tactometry.errors import InvalidParameter


@pytest.fixture(scope="module")
def published() -> pd.DataFrame:
    table = long_table(np.array(PUBLISHED.split(), dtype=float).reshape(8, 12))
    return table.assign(octave=np.log2(table["force"]))


def test_published_model_with_force_as_covariate(published) -> None:
    terms = {"factors": ["freq"], "covariates": ["octave"], "base": {"freq": 120}}
    found = mixed_model(published, dependent="y", subject="subject", **terms)
    estimates = found.coefficients.set_index("term")["estimate"]
    truth = {"Intercept": 27.93333, "freq = 60": 4.81250, "freq = 240": -2.93750, "freq = 480": -0.94167}
    truth |= {"octave": -0.82812, "freq = 60 * octave": 0.48438, "freq = 240 * octave": 0.35938}
    assert estimates.to_dict() == pytest.approx(truth | {"freq = 480 * octave": -0.20312}, abs=5e-6 + 5e-6)
    assert found.residual_variance == pytest.approx(0.4317599, abs=2e-6)
    assert found.participant_variance == pytest.approx(2.5767432, rel=1e-4)
    assert found.log_likelihood == pytest.approx(-114.811057, abs=1e-4)
    assert found.status is ModelStatus.OK


def test_published_cell_means_model_and_its_closed_form(published) -> None:
    """In a balanced design the variances follow from mean squares."""
    found = mixed_model(published, dependent="y", factors=WITHIN, subject="subject")
    values = np.array(PUBLISHED.split(), dtype=float).reshape(8, 3, 4)
    design = WithinDesign(values, ("force", "freq"), ((0, 1, 2), (0, 1, 2, 3)), tuple(range(8)))
    errors = sum(effect.ss_error for effect in effects(design)) / (7 * 11)
    subjects = 12 * values.mean(axis=(1, 2)).var(ddof=1)
    assert found.residual_variance == pytest.approx(errors, rel=1e-8)
    assert found.participant_variance == pytest.approx((subjects - errors) / 12, rel=1e-6)
    assert (found.residual_variance, found.participant_variance) == pytest.approx((0.4297891, 2.5768999), rel=1e-4)


def test_mixed_model_with_one_factor_equals_anova() -> None:
    values = drawn((9, 4), np.random.default_rng())
    row = mixed_model(any_table(values), dependent="y", factors=["force"], subject="subject").terms.iloc[0]
    anova = repeated_measures(any_table(values), dependent="y", within="force", subject="subject")
    effect, error = anova.iloc[0], anova.iloc[1]
    if error["MS"] < 4 * values.mean(axis=1).var(ddof=1):
        assert row["F"] == pytest.approx(effect["F"], rel=1e-6)
    assert (row["df1"], row["df2"]) == (effect["DF"], error["DF"])


def test_statsmodels_restricted_likelihood_is_nowhere_higher() -> None:
    """If its search ends at the maximum, the variances agree too."""
    from statsmodels.regression.mixed_linear_model import MixedLM

    rng = np.random.default_rng()
    n_alike = 0
    for _ in range(12):
        table = any_table(drawn((10, 3), rng)).iloc[rng.permutation(30)[:26]]
        own = mixed_model(table, dependent="y", factors=["force"], subject="subject")
        x = np.stack([np.ones(26), table["force"] == 1, table["force"] == 2], axis=1).astype(float)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            peer = MixedLM(table["y"].to_numpy(), x, table["subject"].to_numpy()).fit(reml=True)
        assert own.log_likelihood >= peer.llf - 1e-8
        if own.log_likelihood < peer.llf + 1e-6 and own.participant_variance > 0.2 * own.residual_variance:
            n_alike += 1
            assert own.participant_variance == pytest.approx(float(peer.cov_re[0, 0]), rel=0.05)
            assert own.coefficients["se"].to_numpy() == pytest.approx(peer.bse_fe, rel=0.05)
    assert n_alike > 0


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_hard_scales_have_the_same_tests(published, scale) -> None:
    one, other = (
        mixed_model(table, dependent="y", factors=["freq", "force"], subject="subject")
        for table in (published, published.assign(y=published["y"] * scale))
    )
    errors = [found.terms["F"] for found in (other, one)]
    hard_case("mixed model of values of 1e-299 to 1e301: F", *errors, 1e-6, against="values of 1")
    assert other.coefficients["t"].to_numpy() == pytest.approx(one.coefficients["t"].to_numpy(), rel=1e-6)
    assert other.terms["p"].to_numpy() == pytest.approx(one.terms["p"].to_numpy(), rel=1e-6)
    assert other.participant_sd == pytest.approx(one.participant_sd * scale, rel=1e-4)
    assert other.coefficients["high"].to_numpy() == pytest.approx(one.coefficients["high"].to_numpy() * scale, rel=1e-6)


def test_each_term_is_averaged_over_the_others(published) -> None:
    """Compare with sums of squares over the common error of the balanced design."""
    found = mixed_model(published, dependent="y", factors=WITHIN, subject="subject").terms.set_index("term")
    anova = repeated_measures(published, dependent="y", within=WITHIN, subject="subject").set_index("Source")
    error = (anova["MS"] / anova["F"] * anova["ddof2"]).sum() / anova["ddof2"].sum()
    assert found.loc[anova.index, "F"].to_numpy() == pytest.approx((anova["MS"] / error).to_numpy(), rel=1e-6)
    assert (found["df2"] == 7 * 11).all()


def test_between_factor_is_tested_against_participant_variance(published) -> None:
    own = np.repeat(np.random.default_rng().normal(0, 9, 8), 12)
    hands = np.repeat(["left", "right"], 48)
    table = published.assign(y=published["y"] + own, hand=hands)
    found = mixed_model(table, dependent="y", factors=["hand", "freq"], subject="subject").terms.set_index("term")
    means = table.groupby(["subject", "hand", "freq"], as_index=False)["y"].mean()
    peer = mixed_anova(means, dependent="y", within="freq", between="hand", subject="subject").set_index("Source")
    assert found.loc["hand", ["df1", "df2"]].tolist() == [1, 6]
    assert found.loc["hand", "F"] == pytest.approx(peer.loc["hand", "F"], rel=1e-4)
    assert found.loc["freq", "df2"] == 96 - 8 - 2 * 3


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_unit_and_offset_do_not_matter(published, scale) -> None:
    one = mixed_model(published, dependent="y", factors=["freq"], subject="subject")
    moved = published.assign(y=published["y"] * scale + 3 * scale)
    other = mixed_model(moved, dependent="y", factors=["freq"], subject="subject")
    assert other.coefficients["t"].to_numpy()[1:] == pytest.approx(one.coefficients["t"].to_numpy()[1:], rel=1e-4)
    assert other.participant_variance == pytest.approx(one.participant_variance * scale**2, rel=1e-3)


def test_identical_participants_have_singular_fit() -> None:
    values = drawn((8, 4), np.random.default_rng())
    centred = values - values.mean(axis=1, keepdims=True)
    found = mixed_model(any_table(centred), dependent="y", factors=["force"], subject="subject")
    assert (found.status, found.participant_variance) == (ModelStatus.SINGULAR, 0.0)
    assert "a singular but valid fit" in found.notes[0]
    assert np.isfinite(found.coefficients.drop(columns="term").to_numpy(dtype=float)).all()


def test_names_with_spaces_are_names(published) -> None:
    renamed = published.rename(columns={"freq": "the frequency / Hz", "y": "log y"})
    found = mixed_model(renamed, dependent="log y", factors=["the frequency / Hz"], subject="subject")
    assert found.coefficients["term"][1] == "the frequency / Hz = 120"


@pytest.mark.parametrize(
    ("change", "arguments", "message"),
    [
        ({}, {"factors": ["frec"]}, "mixed_model: found no column 'frec'; did you mean 'freq'?"),
        ({}, {"factors": ["freq"], "base": {"freq": 61}}, "base: found freq = 61, expected one of 60, 120, 240, 480"),
        ({"octave": np.inf}, {"covariates": ["octave"]}, "octave, row 0: found inf (y = 30.4, subject = P1), expected"),
        ({"subject": "P1"}, {"factors": ["freq"]}, "subject: found 1 participant, expected at least 2"),
        ({"octave": 3.0}, {"covariates": ["octave"]}, "octave: found a column (octave) that depends on earlier terms"),
        ({}, {"factors": ["freq", "freq"]}, "mixed_model: found y, subject, freq, freq, expected each column once"),
        ({}, {"factors": WITHIN}, "force * freq: found a column (force = 2.0 * freq = 480) that depends on earlier te"),
    ],
)
def test_unfittable_tables_are_rejected(published, change, arguments, message) -> None:
    table = published.assign(**change)
    if arguments.get("factors") == WITHIN:  # without one combination of levels
        table = table[(table["freq"] != 480) | (table["force"] != 2)]
    with pytest.raises(InvalidParameter, match=re.escape(message)):
        mixed_model(table, dependent="y", subject="subject", **arguments)
