"""Tests of exclusion rules and of inputs given alongside a data set."""

import json

import numpy as np
import pandas as pd
import pytest
from analysis_data import grid_of_thresholds, write_study
from command_line import output
from places import RECORDED

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.reading.quality import Exclusion

GENERAL = {"quality", "excluded", "sittings", "happenings"}
STAIRCASES = RECORDED / "electrovibration-threshold"
RULE = ["rule_estimate", "rule_sd", "rule_n", "rule_note"]


def planned(path, **rules):
    return analyse(path, plan=AnalysisPlan(Exclusion(**rules), hierarchical=False))


def tables_with(analysis, code):
    tables = analysis.tables.items()
    return {name for name, table in tables if "participant" in table and code in set(table["participant"])} - GENERAL


@pytest.mark.parametrize(
    ("name", "share", "code"), [("inquiries", 0.1, "P03"), ("electrovibration-threshold", 0.01, "P01")]
)
def test_excluded_participant_is_absent_from_result_tables(name, share, code) -> None:
    assert len(tables_with(planned(RECORDED / name), code)) >= 3
    without = planned(RECORDED / name, invalid_share_max=share)
    assert without.tables["excluded"]["participant"].tolist() == [code]
    assert tables_with(without, code) == set()


def test_rule_estimate_includes_excluded_answers() -> None:
    """The procedure received those answers."""
    whole, some = planned(STAIRCASES), planned(STAIRCASES, latency_max_s=0.8)
    keys = ["participant", "force_n", "frequency_hz"]
    estimates, kept = (each.tables["thresholds"].set_index(keys)[RULE] for each in (whole, some))
    assert 0 < len(some.trials.rows) < len(whole.trials.rows)
    pd.testing.assert_frame_equal(kept, estimates.loc[kept.index])


@pytest.mark.parametrize(
    ("level_scale", "is_replayed"), [(None, True), ("linear", True), ("log10", False), ("db", False)]
)
def test_rule_is_replayed_only_on_recorded_scale(level_scale, is_replayed, tmp_path) -> None:
    blocks, path = [], tmp_path / "trials.csv"
    (recorded, *_) = (STAIRCASES / "data").glob("*.csv")
    path.write_text(recorded.read_text("utf-8").replace("dB re 1 V", "V"), "utf-8")
    analyse(path, level_scale=level_scale, replay=lambda block: blocks.append(block) or {})
    assert bool(blocks) == is_replayed


def test_without_courses_there_is_no_table_of_touches(tmp_path) -> None:
    found = analyse(RECORDED / "same-different", report=tmp_path / "r.html", touches=pd.DataFrame)
    assert "touches" not in found.tables
    assert not (tmp_path / "r_tables" / "touches.csv").exists()


def test_excluded_answers_equal_missing_answers(tmp_path) -> None:
    recorded = sorted((STAIRCASES / "data").glob("*.csv"))
    rows = pd.concat([pd.read_csv(path, dtype=str, keep_default_na=False) for path in recorded], ignore_index=True)
    is_slow = pd.to_numeric(rows["latency_s"]) > 1.1
    assert is_slow.any()
    paths = tmp_path / "all.csv", tmp_path / "quick.csv"
    for path, some in zip(paths, (rows, rows[~is_slow]), strict=True):
        some.to_csv(path, index=False)
    left_out, never_given = planned(paths[0], latency_max_s=1.1), planned(paths[1])
    for name in ("thresholds", "goodness", "counts", "rates", "tracks", "force_participants"):
        one, other = (each.tables[name].drop(columns=RULE, errors="ignore") for each in (left_out, never_given))
        pd.testing.assert_frame_equal(one, other)


def test_anova_names_participant_it_leaves_out(tmp_path, capsys) -> None:
    """The primary analysis includes bounds; the ANOVA is a check."""
    rng = np.random.default_rng(4)
    thresholds = grid_of_thresholds(5, {(0.5,): 20.0, (1.0,): 22.0, (2.0,): 24.0}, 1.0, rng)
    del thresholds["P05", (2.0,)]
    path = write_study(tmp_path / "trials.csv", thresholds, ["force_n"], rng=rng)
    said = "the analysis of variance, a check, leaves out participant P05"
    report = tmp_path / "report.html"
    assert said in " ".join(output(capsys, "analyse", path, "--report", report).split())
    assert said in report.read_text("utf-8").replace("The analysis", "the analysis")
    (found,) = json.loads(output(capsys, "analyse", path, "--json"))["outcomes"]
    assert found["left_out"] == ["participant P05"]
    assert any(said in note for note in found["notes"])
