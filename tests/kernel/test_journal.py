"""Journal and data set: damage, locks, full disks, rebuilt tables."""

import shutil
import subprocess
import sys
from pathlib import Path

import catalogue
import msgspec
import numpy as np
import pytest
from examples import examples
from full_disk import files_of_at_most
from hard_cases import exact_case
from hypothesis import given, strategies as st
from places import ROOT
from tutorial_session import EXPERIMENT, TOML, journal_of, live

from tactometry.errors import DeviceFailed, InvalidFile, SessionInUse
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.experiments.study.session_plan import stream
from tactometry.records.data_set import Session, trials_csv
from tactometry.records.journal import decode_entry, encode_entry, read
from tactometry.records.open_journal import Journal
from tactometry.records.open_session import OpenSession
from tactometry.session.answer import Chosen, Done
from tactometry.session.request import Choose, Record, Wait
from tactometry.trials.columns import RIGS
from tactometry.trials.trial import Trial


def files(root):
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and not path.name.endswith("_interruptions.jsonl")
    }


def test_equal_seeds_give_equal_bytes(tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        live(tmp_path / name, Who("P01", seed=seed))
    assert files(tmp_path / "a") == files(tmp_path / "b") != files(tmp_path / "c")


def test_trials_file_is_derived_from_the_journal(lived):
    recording = read(journal_of(lived))
    columns = EXPERIMENT.design(TOML).columns
    trials = next((lived / "data").glob("*.csv")).read_bytes()
    assert trials == trials_csv(recording.trials, Session("P01", 1, "tutorial"), "simulated", columns)


@pytest.mark.parametrize("rig", RIGS)
def test_trials_are_synced_singly_except_in_simulations(tmp_path, synced, rig):
    keeper = OpenSession(tmp_path, EXPERIMENT.design(TOML), Session("P01", 1, "tutorial"), rig, resume=False)
    before = len(synced)
    for n in range(5):
        keeper.append(Record(Trial(1, n, {}, "staircase", 20.0, "V", "yes_no", 1)), Done(float(n)))
    assert len(synced) - before == (0 if rig == "simulated" else 5)
    keeper.close()
    journal = keeper.journal.path.read_bytes()
    assert journal.count(b"\n") == 5
    assert len(synced) - before == (2 if rig == "simulated" else 6)


def test_number_of_syncs_is_independent_of_trials(tmp_path, synced):
    n_trials = live(tmp_path / "d").n_trials
    assert len(synced) < 20 < n_trials


def test_recorded_session_is_not_overwritten(lived):
    before = files(lived)
    with pytest.raises(InvalidFile, match="this session has already been recorded, expected a new session"):
        live(lived)
    assert files(lived) == before


@given(cut=st.integers(0, 10**6))
@examples(40, deadline=None)
def test_resuming_a_cut_journal_gives_the_same_bytes(whole, tmp_path_factory, cut):
    torn = Path(shutil.copytree(whole, tmp_path_factory.mktemp("torn") / "d"))
    journal = journal_of(torn)
    with journal.open("r+b") as file:
        file.truncate(cut % (journal.stat().st_size + 1))
    live(torn, resume=True)
    assert files(torn) == files(whole)
    exact_case("a journal cut at any byte", against="the same bytes after going on")


def test_resuming_keeps_and_reports_cut_bytes(lived):
    journal = journal_of(lived)
    content = journal.read_bytes()
    journal.write_bytes(content[:-400])
    recorded = live(lived, resume=True)
    assert "the last sitting ended after " in recorded.repaired
    assert next((lived / "journals").glob("*_interruptions.jsonl")).stat().st_size > 0


@given(line=st.integers(0, 10**6), bit=st.integers(0, 7), place=st.integers(0, 10**6))
@examples(60, deadline=None)
def test_damaged_line_is_reported_and_changes_nothing(whole, tmp_path_factory, line, bit, place):
    root = Path(shutil.copytree(whole, tmp_path_factory.mktemp("damaged") / "d"))
    journal = journal_of(root)
    lines = journal.read_bytes().split(b"\n")[:-1]
    n = line % len(lines)
    hurt = bytearray(lines[n])
    hurt[place % len(hurt)] ^= 1 << bit
    if b"\n" in hurt:
        return
    lines[n] = bytes(hurt)
    journal.write_bytes(b"\n".join(lines) + b"\n")
    before = files(root)
    with pytest.raises(InvalidFile, match=rf"line {n + 1}: the line is damaged"):
        live(root, resume=True)
    assert files(root) == before
    exact_case("any bit of a journal turned", against="its line is named, nothing changes")


def test_journal_refuses_a_second_process(lived):
    script = (
        "import sys; from pathlib import Path; from tactometry.records.open_journal import Journal\n"
        "try: Journal(Path(sys.argv[1]), resume=True)\n"
        "except Exception as error: print(type(error).__name__, error)"
    )
    held = Journal(journal_of(lived), resume=True)
    try:
        with pytest.raises(SessionInUse, match="another process is writing this session"):
            Journal(journal_of(lived), resume=True)
        other = subprocess.run(
            [sys.executable, "-c", script, str(journal_of(lived))], capture_output=True, text=True, check=True
        )
    finally:
        held.close()
    assert other.stdout.startswith("SessionInUse")
    assert "another process is writing this session" in other.stdout


@pytest.mark.parametrize("n_bytes", [0, 1, 2000, 5000, 9000])
def test_full_disk_ends_session_without_losing_trials(whole, tmp_path, n_bytes):
    full = tmp_path / "full"
    with files_of_at_most(n_bytes), pytest.raises(DeviceFailed, match="expected free disk space") as refused:
        live(full)
    assert refused.value.exit_status == 3
    live(full, resume=True)
    assert files(full) == files(whole)
    exact_case("a disk that is full", against="the same bytes after going on")


FILL_DISK = """
import sys
from pathlib import Path
from tactometry.errors import DeviceFailed
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.study_file import load

disk = Path(sys.argv[1])
try:
    list(simulate(Simulation(load("tutorial")[1], "tutorial", disk, 50, 1)))
except DeviceFailed as error:
    print(error)
journals = [path.read_bytes() for path in (disk / "journals").glob("*.jsonl")]
print("whole" if all(content.endswith(b"\\n") for content in journals if content) else "torn")
"""


def test_session_on_a_real_full_disk_resumes(tmp_path):
    """The small disk is in the mount namespace of its process."""
    script, disk = tmp_path / "fill.py", tmp_path / "disk"
    disk.mkdir()
    script.write_text(FILL_DISK)
    words = f"mount -t tmpfs -o size=64k tmpfs {disk} || exit 77; exec {sys.executable} {script} {disk}"
    done = subprocess.run(["unshare", "--mount", "sh", "-c", words], capture_output=True, text=True, check=False)
    if done.returncode in (1, 77) and not done.stdout:
        pytest.skip("mounting a small disk needs the rights of root")
    said, journals = done.stdout.splitlines()
    assert "No space left on device" in said
    assert "expected free disk space" in said
    assert journals == "whole"


def test_journal_refuses_numbers_that_are_not_finite(tmp_path):
    journal = Journal(tmp_path / "j.jsonl", resume=False)
    with pytest.raises(DeviceFailed, match="cannot be stored without loss, expected finite numbers"):
        journal.append(Wait(1.0), Done(float("nan")))
    journal.close()
    assert (tmp_path / "j.jsonl").read_bytes() == b""


@given(
    factors=st.dictionaries(
        st.from_regex(r"[a-z]{1,8}_hz", fullmatch=True), st.floats(allow_nan=False, allow_infinity=False)
    ),
    level=st.none() | st.floats(allow_nan=False, allow_infinity=False),
    response=st.none() | st.integers(0, 9) | st.text(max_size=20),
)
def test_trials_survive_encoding(factors, level, response):
    trial = Trial(1, 1, factors, "staircase", level, "V", "yes_no", response)
    line = encode_entry(Record(trial), Done(0.5))
    assert decode_entry(msgspec.json.decode(line)) == (Record(trial), Done(0.5))


def test_choices_keep_their_type_when_encoded():
    entry = (Choose("felt", (0, 1), ("no", "yes")), Chosen(1, 0.5, 0.25, "2026-01-01T00:00:00+00:00"))
    assert decode_entry(msgspec.json.decode(encode_entry(*entry))) == entry


def test_folder_of_another_study_is_refused(lived):
    with pytest.raises(InvalidFile, match="study.toml: found another study, or other settings"):
        record(EXPERIMENT, TOML + b"\n# edited", lived, Who("P02", seed=1), simulated(EXPERIMENT, Who("P02", seed=1)))


def test_head_states_seed_versions_and_observer(lived):
    head = read(journal_of(lived)).head
    assert (head.seed, head.participant, head.rig, head.study) == (1, "P01", "simulated", "tutorial")
    assert head.versions["tactometry"]
    assert head.observer["kind"] == "SignalDetectionObserver"
    assert (lived / "study.toml").read_bytes() == TOML


def test_catalogue_contains_every_built_in_study():
    assert {path.stem for path in (ROOT / "experiments").glob("*.toml")} <= set(catalogue.PROTOCOLS)


def test_streams_differ_by_use():
    draws = {tuple(stream(1, *keys).integers(2**60, size=2)) for keys in [("a",), ("b",), ("a", 1), ("a", 1, 2), ()]}
    assert len(draws) == 5
    assert np.array_equal(stream(3, "x").random(4), stream(3, "x").random(4))
