"""Tests of applied force, time in band, exclusion rules and what they leave out."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from analysis_data import grid_of_thresholds, write_study
from command_line import output
from places import RECORDED

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.plan import AnalysisPlan, plan_of, read_plan
from tactometry.analysis.reading.quality import Exclusion, exclude, quality
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.analysis.tasks.applied_force import force_of_participants, force_table, has_force
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.study.study_file import locate, parse

COLUMNS = "participant,session,study,block,trial,force_n,procedure,level,level_unit,task,response,correct,latency_s"
COLUMNS += ",force_mean_n,force_sd_n,force_in_band,valid,catch"


def trials(tmp_path, rows):
    """Write participant, target, mean force, time in band, valid, catch, response and latency."""
    lines = [COLUMNS]
    for n, (code, target, mean, band, valid, catch, response, latency) in enumerate(rows, 1):
        level = "" if catch else "20"
        lines.append(
            f"{code},1,s,1,{n},{target},c,{level},V,yes_no,{response},,{latency},{mean},0.05,{band},{valid},{catch}"
        )
    path = tmp_path / "t.csv"
    path.write_text("\n".join(lines) + "\n")
    return read_trials(path)


@pytest.fixture
def some(tmp_path):
    rows = [
        ("P1", 0.5, 0.52, 0.9, 1, 0, 1, 0.5),
        ("P1", 0.5, 0.60, 0.7, 1, 0, 0, 0.2),
        ("P1", 3, 2.4, 1.0, 1, 0, 1, 9.0),
        ("P1", 3, 9.9, 0.1, 0, 0, 1, 1.0),
        ("P1", 3, "", "", 1, 1, 1, 1.0),
        ("P2", 0.5, 0.50, 1.0, 1, 0, 1, 1.0),
        ("P2", 3, 3.2, 0.85, 1, 0, 1, 1.0),
        ("P2", 3, 3.4, 0.95, 1, 1, 0, 1.0),
    ]
    return trials(tmp_path, rows)


def test_participant_force_uses_used_trials_only(some) -> None:
    own = force_of_participants(used_rows(some), some.factors).set_index(["participant", "force_n"])
    assert has_force(some.rows)
    assert own.loc[("P1", 0.5), "force_mean_n"] == pytest.approx(0.56)
    assert own.loc[("P1", 0.5), "force_deviation_n"] == pytest.approx(0.06)
    assert own.loc[("P1", 3.0), "force_mean_n"] == pytest.approx(2.4)
    assert own.loc[("P2", 3.0), "force_in_band"] == pytest.approx(0.9)
    assert own["n_trials"].tolist() == [2, 1, 1, 2]


def test_the_table_has_means_over_participants(some) -> None:
    table = force_table(force_of_participants(used_rows(some), some.factors), ["force_n"])
    row = table.iloc[1]
    assert row[["mean", "sd"]].tolist() == pytest.approx([2.85, np.std([2.4, 3.3], ddof=1)])
    assert row[["n", "n_trials"]].tolist() == [2, 3]
    assert row["text"] == "2.85 ± 0.64 N, 95 % in band"
    assert (row["mean_low"], row["mean_high"]) == (None, None)  # fewer than three values of a bounded quantity


def test_one_participant_has_a_mean_without_an_interval(some) -> None:
    own = force_of_participants(used_rows(some), some.factors)
    table = force_table(own[own["participant"] == "P2"], ["force_n"])
    assert table["sd"].isna().all()
    assert table["text"].tolist() == ["0.500 N, 100 % in band", "3.30 N, 90 % in band"]


@pytest.mark.parametrize(
    ("rules", "lost"),
    [
        ({}, []),
        ({"force_in_band_share_min": 0.8}, [("P1", "force_in_band_share_min", 0.8, 2)]),
        ({"force_deviation_ratio_max": 0.15}, [("P1", "force_deviation_ratio_max", 0.15, 3)]),
        ({"force_in_band_share_min": 0.7}, [("P1", "force_in_band_share_min", 0.7, 1)]),
        ({"latency_min_s": 0.2, "latency_max_s": 9.0}, []),
        ({"latency_min_s": 0.3}, [("P1", "latency_min_s", 0.3, 1)]),
        ({"latency_max_s": 5.0}, [("P1", "latency_max_s", 5.0, 1)]),
        ({"false_alarm_share_max": 0.25}, [("P1", "false_alarm_share_max", 0.25, 5)]),
        ({"invalid_share_max": 0.1}, [("P1", "invalid_share_max", 0.1, 5)]),
        ({"invalid_share_max": 0.2}, []),
    ],
)  # fmt: skip
def test_exclusion_rule_lists_what_it_leaves_out(some, rules, lost) -> None:
    kept, table = exclude(some, Exclusion(**rules), quality(some))
    assert [tuple(row) for row in table.itertuples(index=False)] == lost
    if lost and lost[0][1] in ("false_alarm_share_max", "invalid_share_max"):
        assert set(kept.rows["participant"]) == {"P2"}
    assert len(kept.rows) >= 8 - sum(row[3] for row in lost)


def test_unmeasured_force_triggers_no_exclusion(some) -> None:
    kept, _ = exclude(some, Exclusion(force_in_band_share_min=0.99, force_deviation_ratio_max=0.0), quality(some))
    assert kept.rows["force_mean_n"].isna().sum() == 1


def test_a_plan_is_read_from_a_file(tmp_path) -> None:
    file = tmp_path / "plan.toml"
    file.write_text("[exclusion]\nforce_in_band_share_min = 0.8\nlatency_max_s = 10\n[equivalence]\nforce_n = 1\n")
    plan = read_plan(file)
    assert plan.exclusion.stated() == {"force_in_band_share_min": 0.8, "latency_max_s": 10}
    assert plan.equivalence == {"force_n": 1.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[exclusions]", "exclusions: found an unknown key, expected one of exclusion, equivalence, hierarchical, pri"),
        ("[exclusion]\nin_band = 0.8", "exclusion.in_band: found an unknown key, expected one of force_in_band_share_"),
        ("[exclusion]\nforce_in_band_share_min = 80", "share_min: found 80.0, expected a number from 0 to 1"),
        ("[exclusion]\nlatency_max_s = -1", "latency_max_s: found -1.0, expected a number from 0"),
        ("[exclusion]\nlatency_max_s = nan", "latency_max_s: found nan, expected a number from 0"),
        ("[exclusion]\nlatency_min_s = 1\nlatency_max_s = 1", "found 1.0, expected more than latency_min_s, 1.0"),
        ("[exclusion]\nlatency_max_s = 'long'", "latency_max_s: found 'long', expected a number"),
        ("[equivalence]\nforce_n = 0", "equivalence.force_n: found 0.0, expected a difference above 0"),
        ("= 3", "found no valid TOML"),
    ],
)
def test_invalid_plan_is_rejected(tmp_path, text, message) -> None:
    file = tmp_path / "plan.toml"
    file.write_text(text)
    with pytest.raises(InvalidFile, match=re.escape(message)):
        read_plan(file)


def test_exclusion_rule_names_its_missing_column(some) -> None:
    without = replace(some, rows=some.rows.drop(columns="latency_s"))
    with pytest.raises(InvalidParameter, match="latency_max_s: found no column 'latency_s', which this rule requires"):
        exclude(without, Exclusion(latency_max_s=3.0), quality(without))
    assert isinstance(exclude(without, Exclusion(), quality(without))[1], pd.DataFrame)


def data_set(tmp_path, analysis):
    """Write a yes/no study of two participants, one of whom says yes in every catch trial."""
    (tmp_path / "data").mkdir()
    (tmp_path / "study.toml").write_text(f'name = "s"\n{analysis}')
    rows = [
        f"{code},1,s,1,{n},1,c,{'' if catch else n},V,yes_no,{answer},,1,,,,1,{catch}"
        for code, alarm in (("P1", 1), ("P2", 0))
        for n, catch, answer in [*((n, 0, int(n > 3)) for n in range(1, 8)), (8, 1, alarm), (9, 1, alarm)]
    ]
    (tmp_path / "data" / "all_data.csv").write_text("\n".join([COLUMNS, *rows]) + "\n")
    return tmp_path


STATED = "[analysis]\nhierarchical = false\nexclusion = { false_alarm_share_max = 0.3, latency_min_s = '100 ms' }\n"


def test_plan_of_study_is_used(tmp_path) -> None:
    found = analyse(data_set(tmp_path, STATED))
    assert found.plan.exclusion.stated() == {"false_alarm_share_max": 0.3, "latency_min_s": 0.1}
    assert set(found.trials.rows["participant"]) == {"P2"}
    assert found.tables["excluded"]["rule"].tolist() == ["false_alarm_share_max"]


def test_given_plan_replaces_plan_of_study(tmp_path) -> None:
    found = analyse(data_set(tmp_path, STATED), plan=AnalysisPlan(hierarchical=False))
    assert set(found.trials.rows["participant"]) == {"P1", "P2"}


@pytest.mark.parametrize(
    ("text", "message"), [("[analysis.exclusions]", ", analysis.exclusions: found"), ("= 3", ": found no valid TOML")]
)
def test_a_damaged_plan_of_a_study_is_refused(tmp_path, text, message) -> None:
    with pytest.raises(InvalidFile, match=re.escape(f"study.toml{message}")):
        plan_of(data_set(tmp_path, text))


def test_study_with_impossible_plan_is_rejected() -> None:
    content = locate("electrovibration-threshold").read_bytes()
    assert parse(content + STATED.encode(), "s.toml").analysis["hierarchical"] is False
    wrong = b"[analysis.equivalence]\nforce = 1.0\n"
    with pytest.raises(InvalidFile, match=re.escape("s.toml, analysis.equivalence.force: found no such factor")):
        parse(content + wrong, "s.toml")


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


def test_no_table_of_touches_without_courses(tmp_path) -> None:
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
