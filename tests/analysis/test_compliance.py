"""Tests of applied force, time in band, and exclusion rules."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

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


def test_unmeasured_force_breaks_no_exclusion_rule(some) -> None:
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
