"""Heads of a session's sittings, and reported changes between them."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from places import RECORDED
from sound_sitting import SOUND, Attended, sit
from tables import contents, is_sound, trial_rows
from tutorial_session import EXPERIMENT, STUDY, TOML, WHO, journal_of

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.trials import read_trials
from tactometry.analysis.report.page import render
from tactometry.analysis.report.summary import summary
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.bench.bench_file import _stated, parse_bench
from tactometry.experiments.data_sets.replaying import replay_data_set
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.records.data_set import Session
from tactometry.records.head import differences, heads
from tactometry.records.journal import encode, read
from tactometry.session.request import Record


def test_changed_facts_of_a_sitting_are_reported(tmp_path):
    assert sit(tmp_path, SOUND, stops_at=4) == []
    louder = {**SOUND, "output_volts_per_unit": 400.0, "output_n_underruns": 9, "utc_minus_clock_s": 2.0}
    assert sit(tmp_path, louder, stops_at=3, resume=True) == [
        "changes since the last part of this session: output_volts_per_unit was 200.0, is 400.0"
    ]
    assert sit(tmp_path, louder, resume=True) == []
    recording = read(journal_of(tmp_path))
    assert [head.facts["output_volts_per_unit"] for head in recording.sittings] == [200.0, 400.0, 400.0]
    assert [head.started_utc is None for head in recording.sittings] == [False] * 3
    assert heads(journal_of(tmp_path)) == recording.sittings
    change = "sitting 2 differs from the previous one: output_volts_per_unit was 200.0, is 400.0"
    assert validate(tmp_path).notes == (f"journals/{journal_of(tmp_path).name}: {change}",)
    assert validate(tmp_path).defects == ()
    assert replay_data_set(tmp_path)[0].changes == (change,)


def test_sitting_begins_when_the_last_ended(tmp_path):
    sit(tmp_path, SOUND, stops_at=4)
    ended_s = [answer.at_s for request, answer in read(journal_of(tmp_path)).entries if isinstance(request, Record)]
    sit(tmp_path, SOUND, resume=True)
    assert [head.begun_s for head in read(journal_of(tmp_path)).sittings] == [0.0, ended_s[-1]]


def test_pages_that_were_read_do_not_come_again(tmp_path, monkeypatch):
    """The session stops in the first touch, after welcome and instructions."""
    asked, answer = [], Attended.answer
    monkeypatch.setattr(Attended, "answer", lambda rig, request: (asked.append(request), answer(rig, request))[1])
    sit(tmp_path, SOUND, stops_at=1)
    *read_before, interrupted = asked
    sit(tmp_path, SOUND, resume=True)
    assert [request.message for request in read_before] == ["welcome", "instructions_yes_no", "block"]
    assert asked[len(read_before) + 1] == interrupted
    assert is_sound(tmp_path)


def test_complete_session_gets_no_new_head(tmp_path):
    sit(tmp_path, SOUND)
    before = journal_of(tmp_path).read_bytes()
    assert sit(tmp_path, {}, resume=True) == []
    assert journal_of(tmp_path).read_bytes() == before


@pytest.mark.parametrize(
    ("name", "before", "after", "is_told"),
    [
        ("frame_period_s", 0.016667, 0.016701, False),
        ("frame_period_s", 0.016667, 0.013333, True),
        ("hand_n_samples", 1, 2, False),
        ("hand_clock_offset_s", 1.0, 2.0, False),
        ("force_measured", "2026-11-01 ZG", "2026-11-01 AB", True),
        ("position_sensor", None, "udp", True),
        ("limit_voltage_peak_v", 100.0, 101.0, True),
        ("limit_duty", 0.030999999999999996, 0.031, False),
    ],
)
def test_changed_counts_and_clocks_are_not_reported(whole, name, before, after, is_told):
    head = read(journal_of(whole)).head
    found = differences(replace(head, facts={name: before}), replace(head, facts={name: after}))
    assert bool(found) == is_told


def test_report_lists_sittings_and_changes(tmp_path, whole):
    louder = {**SOUND, "output_volts_per_unit": 400.0}
    for n, (facts, stops_at) in enumerate(((SOUND, 4), (louder, 3), (louder, None))):
        sit(tmp_path, facts, stops_at=stops_at, resume=n > 0)
    page = render(analyse(tmp_path))
    assert "<h2>Course of the sessions</h2>" in page
    assert ">output_volts_per_unit was 200.0, is 400.0</td>" in page
    rows = summary(analyse(tmp_path))["sittings"]
    changes = ["as it began", "output_volts_per_unit was 200.0, is 400.0", "nothing"]
    assert [(row["sitting"], row["changes"]) for row in rows] == list(enumerate(changes, 1))
    assert "Course of the sessions" not in render(analyse(whole))


def test_changed_bench_key_is_reported(whole):
    def facts(counts, **of_screen):
        tables = {
            "screen": of_screen,
            "sensors": {"hand": {"kind": "lsl", "stream": "hand", "rate_hz": 1000, "n_channels": 1}},
            "force": {"sensor": "hand", "newtons_per_count": counts},
        }
        return {name: value for name, value in _stated(parse_bench(tables)).items() if name.startswith("bench_")}

    head = read(journal_of(whole)).head
    found = differences(replace(head, facts=facts(0.01)), replace(head, facts=facts(0.02, language="fr")))
    assert found == [
        "bench_screen_language was en, is fr",
        "bench_force_calibration_newtons_per_count was 0.01, is 0.02",
    ]


def test_changed_version_is_reported(whole):
    head = read(journal_of(whole)).head
    older = replace(head, versions={**head.versions, "numpy": "1.0"})
    assert differences(older, head) == [f"version of numpy was 1.0, is {head.versions['numpy']}"]


# --- sessions that were recorded before


@pytest.fixture
def repeated(tmp_path):
    return Path(shutil.copytree(RECORDED / "bench-repeated", tmp_path / "d"))


def older(root):
    study, toml = load(str(root / "study.toml"))
    return {"experiment": wire(study, "study.toml"), "toml": toml, "who": Who("P01")}


def test_session_of_an_older_version_keeps_its_format(repeated):
    before = next((repeated / "data").glob("*.csv")).read_bytes()
    described = (repeated / "dataset_description.json").read_bytes()
    sit(repeated, SOUND, resume=True, **older(repeated))
    after = next((repeated / "data").glob("*.csv")).read_bytes()
    assert after.startswith(before)
    assert after.count(b",sus,") == 10
    assert (repeated / "dataset_description.json").read_bytes() == described
    assert (validate(repeated).defects, replay_data_set(repeated)[0].complete) == ((), True)
    assert [head.format for head in read(next((repeated / "journals").glob("*.jsonl"))).sittings] == [1, 1]


def test_new_session_has_the_new_columns(repeated):
    given = older(repeated)
    sit(repeated, SOUND, resume=True, **given)
    sit(repeated, SOUND, **{**given, "who": Who("P02", seed=1)})
    assert validate(repeated).defects == ()
    rows = read_trials(repeated).rows
    assert rows.groupby("participant")["rig"].unique().map(list).to_dict() == {"P01": [""], "P02": ["bench"]}
    described = json.loads((repeated / "dataset_description.json").read_text())["variableMeasured"]
    assert [each["name"] for each in described][-4:] == ["rig", "speed_in_band", "invalid_reason", "n_gaps"]


def test_journal_of_a_newer_format_is_refused(lived):
    head, *_ = journal_of(lived).read_bytes().splitlines(keepends=True)
    values = {name: value for name, value in json.loads(head).items() if name != "crc32"}
    journal_of(lived).write_bytes(encode({**values, "format": 3}))
    with pytest.raises(InvalidFile, match="line 1: found the format 3, expected the head of a journal of format 2"):
        read(journal_of(lived))


# --- people and simulated participants


def simulate(root, who):
    return record(EXPERIMENT, TOML, root, who, simulated(EXPERIMENT, who))


@pytest.mark.parametrize("code", ["P02", WHO.participant])
def test_simulated_participant_among_people_is_refused(tmp_path, code):
    sit(tmp_path, SOUND)
    before = contents(tmp_path)
    with pytest.raises(InvalidFile, match="found sessions of real participants, expected none in the folder of rig"):
        simulate(tmp_path, Who(code, seed=2))
    assert contents(tmp_path) == before


def test_simulation_of_a_person_of_the_same_code_is_refused(tmp_path):
    sit(tmp_path, SOUND)
    before, other = contents(tmp_path), Who(WHO.participant, seed=2)
    with pytest.raises(InvalidParameter, match="--rig: found simulated, but this session began with bench"):
        record(EXPERIMENT, TOML, tmp_path, other, simulated(EXPERIMENT, other), resume=True)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("is_older", [False, True], ids=["marked", "recorded before"])
def test_people_among_simulated_participants_are_refused(tmp_path, lived, is_older):
    root = Path(shutil.copytree(RECORDED / "yes-no", tmp_path / "older")) if is_older else lived
    before = contents(root)
    given = older(root) if is_older else {}
    with pytest.raises(InvalidFile, match="found sessions of simulated participants, expected none in"):
        sit(root, SOUND, **{**given, "who": Who("P77", seed=1)})
    assert contents(root) == before


def test_simulated_data_set_is_described_as_such(lived, tmp_path):
    described = json.loads((lived / "dataset_description.json").read_text())
    assert described["keywords"] == ["simulated data"]
    assert described["description"] == f"{STUDY.description} Simulated participants: no person took part."
    sit(tmp_path / "people", SOUND)
    described = json.loads((tmp_path / "people" / "dataset_description.json").read_text())
    assert "keywords" not in described
    assert described["description"] == STUDY.description
    rigs = [{row["rig"] for row in trial_rows(root)} for root in (lived, tmp_path / "people")]
    assert rigs == [{"simulated"}, {"bench"}]


def test_added_description_is_kept(lived):
    path = lived / "dataset_description.json"
    edited = {**json.loads(path.read_text()), "author": [{"name": "A. Author"}], "description": "Mine."}
    path.write_text(json.dumps(edited))
    simulate(lived, Who("P02", seed=1))
    assert json.loads(path.read_text()) == edited
    assert validate(lived).defects == ()


def test_description_without_study_is_refused(tmp_path):
    (tmp_path / "dataset_description.json").write_text("{}")
    with pytest.raises(InvalidFile, match=r"found no list 'variableMeasured'"):
        simulate(tmp_path, WHO)
    (tmp_path / "dataset_description.json").write_text('{"variableMeasured": []}')
    with pytest.raises(InvalidFile, match=r"found the description of a data set without its study\.toml"):
        simulate(tmp_path, WHO)
    assert not Session("P01", 1, "tutorial").journal(tmp_path).exists()
