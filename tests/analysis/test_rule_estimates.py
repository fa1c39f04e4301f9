"""Tests of rule estimates against the recorded procedures."""

import json
import shutil
from statistics import fmean, stdev

import pandas as pd
import pytest
from command_line import output
from hypothesis import given, strategies as st
from places import RECORDED
from study_texts import TUTORIAL

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.tasks.rule_estimate import reversals
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse
from tactometry.protocols.bayesian.quest_plus import SharedTrack
from tactometry.protocols.bayesian.weighing import WeighingRun
from tactometry.protocols.procedures.easy import EasyTrials
from tactometry.protocols.procedures.staircase import Staircase
from tactometry.records.data_set import sessions
from tactometry.records.journal import read
from tactometry.session.run import replay

RULES = {
    "staircase": 'start = 34\nsteps = [8, 4, 2]\nlow = -10\nhigh = 40\nn_down = 1\nn_reversals = 8\nn_trials = 40',
    "weighted_staircase": "start = 34\nsteps_up = [6, 3]\nsteps_down = [2, 1]\nlow = -10\nhigh = 40\nn_trials = 40",
    "quest": "start = 20\nstart_sd = 12\nlow = -20\nhigh = 40\nstep = 0.5\ntarget = 0.6\n"
    "guess_rate = 0.05\nn_trials = 25",
    "quest_plus": "low = -10\nhigh = 40\nn_levels = 26\nwidth_low = 4\nwidth_high = 20\nn_widths = 3\n"
    "guess_rates = [0.05]\nn_trials = 25",
}  # fmt: skip


def tracks_at_the_end(root):
    """Yield every track of recorded sessions with its participant."""
    experiment = wire(parse((root / "study.toml").read_bytes(), "study.toml"), "study.toml", begun=True)
    for journal in sessions(root):
        recording = read(journal)
        head = recording.head
        course = experiment.course(head.participant, head.session, head.number, head.seed)
        for track in replay(course, recording.replay(str(journal))):
            yield head.participant, track


def spread_and_number(procedure):
    procedure = procedure.view if isinstance(procedure, EasyTrials) else procedure
    if isinstance(procedure, WeighingRun):
        return procedure.threshold_sd, len(procedure.responses)
    kept = procedure.reversals[2 + len(procedure.reversals) % 2 :]
    return stdev(kept), len(kept)


def in_json(capsys, root):
    return pd.DataFrame(json.loads(output(capsys, "analyse", root, "--json"))["thresholds"])


def study_with(procedure):
    before, rest = TUTORIAL.partition("[procedure]")[0], TUTORIAL.partition("[limits]")[2]
    return f"{before}[procedure]\n{procedure}\n\n[limits]{rest}".encode()


@pytest.mark.parametrize("easy", ["", "easy_share = 0.2"])
@pytest.mark.parametrize("kind", RULES)
def test_rule_estimate_equals_that_of_recorded_session(tmp_path, capsys, kind, easy):
    content = study_with(f'kind = "{kind}"\n{RULES[kind]}\n{easy}')
    list(simulate(Simulation(content, "study", tmp_path / "d", 2, seed=3)))
    found = in_json(capsys, tmp_path / "d").set_index(["participant", "frequency_hz"])
    ended = list(tracks_at_the_end(tmp_path / "d"))
    assert len(ended) == len(found) == 4
    for participant, track in ended:
        row = found.loc[(participant, track.condition.factors["frequency_hz"])]
        if track.procedure.threshold is None:
            assert pd.isna(row["rule_estimate"])
            continue
        sd, n = spread_and_number(track.procedure)
        assert row["rule_estimate"] == pytest.approx(track.procedure.threshold, rel=1e-12)
        assert (row["rule_sd"], row["rule_n"]) == (pytest.approx(sd, rel=1e-12), n)


def test_rule_estimates_cover_shared_tracks_and_sessions(capsys):
    found = in_json(capsys, RECORDED / "quest-plus-tracks")
    by_cell = {}
    for participant, track in tracks_at_the_end(RECORDED / "quest-plus-tracks"):
        assert isinstance(track.procedure, SharedTrack)
        key = (participant, *track.condition.factors.values())
        by_cell.setdefault(key, []).append(track.procedure.threshold)
    named = list(track.condition.factors)
    for _, row in found.iterrows():
        known = [each for each in by_cell[row["participant"], *row[named]] if each is not None]
        expected = pytest.approx(fmean(known), rel=1e-9) if known else None
        assert (None if pd.isna(row["rule_estimate"]) else row["rule_estimate"]) == expected
    assert set(found.loc[found["rule_estimate"].isna(), "rule_note"]) <= {"the rule ended as censored_below"}


def test_easy_trials_are_fitted_without_reversals(tmp_path):
    content = study_with(f'kind = "staircase"\n{RULES["staircase"]}\neasy_share = 0.25\neasy_level = 39.5')
    list(simulate(Simulation(content, "study", tmp_path / "d", 1, seed=3)))
    found = analyse(tmp_path / "d")
    rows, counts = found.trials.rows, found.tables["counts"]
    easy = rows[rows["procedure"] == "easy"]
    assert set(easy["level"]) == {39.5}
    assert counts.loc[counts["level"] == 39.5, "n_trials"].sum() == len(easy) >= 5
    assert set(found.tables["tracks"]["procedure"]) == {"staircase"}


def test_easy_trials_in_plain_table_add_no_reversals(tmp_path):
    lines = plain(tmp_path / "t.csv", "staircase,").read_text().splitlines()
    easy = [f"P1,1,{n}5,red,easy,40,dB,yes_no,1" for n in (3, 8)]
    (tmp_path / "easy.csv").write_text("\n".join([*lines[:4], easy[0], *lines[4:9], easy[1], *lines[9:]]) + "\n")
    found = [analyse(tmp_path / name).tables["thresholds"].iloc[0] for name in ("t.csv", "easy.csv")]
    assert found[0]["rule_estimate"] == found[1]["rule_estimate"]
    assert found[1]["n_trials"] == found[0]["n_trials"] + 2


def test_trials_of_another_study_have_no_rule_estimate(tmp_path, capsys):
    root = shutil.copytree(RECORDED / "quest-plus-tracks", tmp_path / "d")
    (root / "study.toml").write_bytes((RECORDED / "electrovibration-threshold" / "study.toml").read_bytes())
    found = in_json(capsys, root)
    assert found["rule_estimate"].isna().all()
    assert set(found["rule_note"]) == {"these are not trials of the study.toml next to the table"}


LEVELS = (30, 22, 14, 6, 14, 22, 18, 14, 18, 22, 18, 18, 14, 18, 14, 18, 22, 18, 14, 16)
TURNS = (6, 22, 14, 22, 14, 18, 14, 22, 14)


def plain(path, procedure, header="procedure,"):
    rows = [f"participant,session,trial,colour,{header}level,level_unit,task,response"]
    rows += [f"P1,1,{n},red,{procedure}{level},dB,yes_no,{int(level > 15)}" for n, level in enumerate(LEVELS, start=1)]
    path.write_text("\n".join(rows) + "\n")
    return path


def test_reversals_are_found_in_plain_table(tmp_path):
    found = analyse(plain(tmp_path / "t.csv", "staircase,"), report=tmp_path / "r.html").tables["thresholds"].iloc[0]
    kept = TURNS[3:]
    assert (found["rule_estimate"], found["rule_sd"], found["rule_n"]) == (fmean(kept), stdev(kept), len(kept))
    assert found["rule_note"] == "mean of reversals in the levels"
    assert "<th>rule estimate</th>" in (tmp_path / "r.html").read_text()


@pytest.mark.parametrize(
    ("procedure", "header", "why"),
    [
        ("quest,", "procedure,", "without study.toml next to the table, the parameters of quest are unknown"),
        ("constant_stimuli,", "procedure,", "the levels of constant_stimuli do not depend on the answers"),
        ("", "", "the table does not name the procedure"),
    ],
)
def test_missing_rule_estimate_has_reason(tmp_path, procedure, header, why):
    table = plain(tmp_path / "t.csv", procedure, header)
    found = analyse(table, within=["colour"]).tables["thresholds"].iloc[0]
    assert found[["rule_estimate", "rule_sd", "rule_n"]].isna().all()
    assert found["rule_note"] == f"no estimate: {why}"


@given(answers=st.lists(st.booleans(), min_size=1, max_size=60), n_down=st.integers(1, 3))
def test_levels_reveal_all_but_the_last_reversal(answers, n_down):
    rule = Staircase(0.0, (4.0, 2.0), -1e3, 1e3, n_down=n_down, n_reversals=100, n_trials=100)
    for answer in answers:
        rule = rule.after(answer)
    shown = reversals(rule.delivered)
    assert tuple(shown) == rule.reversals[: len(shown)]
    assert len(rule.reversals) - len(shown) in (0, 1)
