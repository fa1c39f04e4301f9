"""Experimenter interventions in journals, tables, events and analysis."""

import json
import shutil
from pathlib import Path

import pytest
from places import RECORDED
from tables import event_rows, trial_rows
from tutorial_session import EXPERIMENT, TOML, WHO, journal_of
from wanting import Wanting

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.trials import read_trials, used_rows
from tactometry.analysis.report.page import render
from tactometry.experiments.data_sets.replaying import rebuild_data_set, replay_data_set
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.recording import RigKind, Who, record, simulated
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import load
from tactometry.files.durable import read_file
from tactometry.records.data_set import Session, trials_csv
from tactometry.records.journal import encode, read
from tactometry.session.request import Intervene

AT = {3: "back 2", 5: "rest", 7: "skip", 13: "back", 16: "end"}


def sit(root, at=AT, *, resume=False, experiment=EXPERIMENT, toml=TOML, who=WHO, **stops):
    """Run a sitting; return its messages and the result (None: interrupted)."""
    rigs, make = [], simulated(experiment, who).make
    n_before = sum(event.kind == "order" for event in read(journal_of(root)).events) if resume else 0

    def wanting(seed, log):
        rigs.append(Wanting(make(seed, log), list(at.items())[n_before:], log, **stops))
        return rigs[0]

    try:
        recorded = record(experiment, toml, root, who, RigKind("bench", wanting), resume=resume)
    except KeyboardInterrupt:
        return rigs[0].said, None
    return rigs[0].said, recorded


@pytest.fixture(scope="module")
def wanted(tmp_path_factory):
    root = tmp_path_factory.mktemp("wanted")
    return root, *sit(root)


@pytest.fixture
def lived(wanted, tmp_path):
    return Path(shutil.copytree(wanted[0], tmp_path / "d"))


SAID = [
    "trial 2 does not count: it is asked again",
    "a rest",
    "block 1 is skipped",
    "trial 13 does not count: it is asked again",
    "block 2 is left, and the session ends",
]


def test_table_and_summary_state_interventions(wanted):
    root, said, recorded = wanted
    assert said == SAID
    lost = [row for row in trial_rows(root) if row["invalid_reason"] == "experimenter"]
    assert [(row["trial"], row["valid"], row["correct"]) for row in lost] == [("2", "0", ""), ("13", "0", "")]
    assert recorded.endings == {"skipped": 2}
    n_invalid = sum(row["valid"] == "0" for row in trial_rows(root))
    assert str(recorded.tally) == f"16 trials, {n_invalid} of them not valid"


def test_events_table_holds_orders_and_results(wanted):
    rows = [row for row in event_rows(wanted[0]) if row["trial_type"] in ("order", "intervention")]
    assert [row["text"] for row in rows if row["trial_type"] == "intervention"] == SAID
    orders = [row for row in rows if row["trial_type"] == "order"]
    assert [row["text"] for row in orders] == ["invalidate", "rest", "skip", "invalidate", "end"]
    assert (orders[0]["block"], orders[0]["trial"], orders[0]["attempt"]) == ("1", "2", "1")


def test_data_set_with_interventions_replays(wanted):
    root = wanted[0]
    assert validate(root).defects == ()
    [replayed] = replay_data_set(root)
    assert (replayed.complete, replayed.n_trials) == (True, 16)
    assert rebuild_data_set(root)[0].changed is False


def test_forged_discarded_trial_is_found(lived):
    path, before, lines = journal_of(lived), 0, []
    for line in path.read_bytes().splitlines():
        value = json.loads(line)
        value.pop("crc32")
        if value.get("request") == "Intervene" and value["asked"]["retracted"]:
            value["asked"]["retracted"] = []
        lines.append(encode(value, before))
        before = int(lines[-1][-11:-3], 16)
    path.write_bytes(b"".join(lines))
    assert any("found a row that differs from the journal" in defect.text for defect in validate(lived).defects)
    with pytest.raises(Exception, match="Intervene.retracted: the recording has"):
        replay_data_set(lived)


def test_retracted_trials_count_as_invalid(wanted):
    assert len(used_rows(read_trials(wanted[0]))) == sum(row["valid"] == "1" for row in trial_rows(wanted[0]))


def test_report_lists_interventions(wanted):
    page = render(analyse(wanted[0]))
    assert page.index("<h3>Events</h3>") > page.index("<h2>Course of the sessions</h2>")
    assert all(f">{said}</td>" in page for said in SAID)


def test_report_lists_orders_before_their_effects(wanted):
    course = analyse(wanted[0]).table("happenings")
    texts = {kind: list(rows["text"]) for kind, rows in course.groupby("trial_type")}
    assert texts["order"] == ["invalidate trial 2", "rest", "skip", "invalidate trial 13", "end"]
    assert texts["intervention"] == SAID


def untimed_rows(root):
    timed = ("onset_s", "latency_s", "timestamp_utc")
    return [{name: cell for name, cell in row.items() if name not in timed} for row in trial_rows(root)]


@pytest.mark.parametrize("stops_late", [False, True], ids=["before", "as it is answered"])
def test_interrupted_session_keeps_all_orders(tmp_path, wanted, stops_late):
    n_requests = len(read(journal_of(wanted[0])).entries)
    for stops_at in range(2 + stops_late, n_requests + 1, 4):
        root = tmp_path / str(stops_at)
        assert sit(root, stops_at=stops_at, stops_late=stops_late)[1] is None
        assert validate(root).defects == ()
        assert sit(root, resume=True)[1] is not None, stops_at
        assert untimed_rows(root) == untimed_rows(wanted[0]), stops_at
        said = [entry.request.said for entry in read(journal_of(root)).entries if isinstance(entry.request, Intervene)]
        assert said == SAID, stops_at
        assert (validate(root).defects, replay_data_set(root)[0].complete) == ((), True)


def test_kill_between_journal_and_table_is_repaired(lived):
    """The interrupted table shows the trials before they were taken back."""
    [path] = (lived / "data").glob("*.csv")
    whole = read_file(path, "a trials file")
    columns = EXPERIMENT.design(TOML).columns
    path.write_bytes(trials_csv(read(journal_of(lived)).rows_at_first, Session("P01", 1, "tutorial"), "bench", columns))
    assert path.read_bytes() != whole
    assert (sit(lived, resume=True)[1].repaired, path.read_bytes()) == (None, whole)


def test_session_of_an_older_version_takes_orders(tmp_path):
    root = Path(shutil.copytree(RECORDED / "bench-repeated", tmp_path / "d"))
    study, toml = load(str(root / "study.toml"))
    older = {"experiment": wire(study, "study.toml"), "toml": toml, "who": Who("P01")}
    [journal] = (root / "journals").glob("*.jsonl")
    n = len(read(journal).trials)
    rigs, make = [], simulated(older["experiment"], older["who"]).make

    def wanting(seed, log):
        rigs.append(Wanting(make(seed, log), {n + 2: "back", n + 4: "end"}, log))
        return rigs[0]

    record(older["experiment"], toml, root, older["who"], RigKind("bench", wanting), resume=True)
    assert (validate(root).defects, replay_data_set(root)[0].complete) == ((), True)
    assert "invalid_reason" not in trial_rows(root)[0]
