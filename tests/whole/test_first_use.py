"""Options of the command line that a new user meets first."""

import re

import pytest
from command_line import call, output, refused
from tables import trial_rows

from tactometry.cli import COMMANDS, GROUPS
from tactometry.experiments.study.study_file import load

POWER = ("power", "tutorial", "--effect", "frequency_hz: 6 dB", "--participants", "4", "--most", "2")
PEOPLE = ("simulate", "tutorial", "--participants", "1")
PERSON = ("run", "tutorial", "--participant", "P01", "--rig", "simulated")


def test_help_lists_each_command_in_one_group(capsys) -> None:
    assert sorted(name for names in GROUPS.values() for name in names) == sorted(COMMANDS)
    said = output(capsys, "--help")
    headings = [said.index(f"{heading}:\n") for heading in GROUPS]
    assert headings == sorted(headings)


def test_new_writes_to_standard_output(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert output(capsys, "new", "tutorial", "--out", "-").encode() == load("tutorial")[1]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", [PEOPLE, PERSON])
def test_drawn_seed_is_printed_and_repeats_the_data(tmp_path, capsys, command) -> None:
    _, said, _ = call(capsys, *command, "--out", tmp_path / "a")
    seed = re.search(r"seed: (\d+) ", said)[1]
    output(capsys, *command, "--out", tmp_path / "b", "--seed", seed)
    tables = [trial_rows(tmp_path / name) for name in ("a", "b")]
    assert tables[0] == tables[1]


def test_power_needs_no_seed(capsys) -> None:
    code, said, text = call(capsys, *POWER)
    assert code == 0
    seed = re.search(r"seed: (\d+) ", said)[1]
    assert f"seed {seed}" in text


def test_resume_of_drawn_seed_names_the_option(tmp_path, capsys) -> None:
    said = refused(capsys, *PEOPLE, "--out", tmp_path / "d", "--resume")
    assert "--seed: found none, expected the seed that the interrupted run printed" in said


def test_resume_reports_when_there_is_nothing_to_resume(tmp_path, capsys) -> None:
    code, said, _ = call(capsys, *PERSON, "--out", tmp_path / "d", "--resume")
    assert code == 0
    assert f"--resume: {tmp_path / 'd'} contains no session 1 of P01 to resume; it begins now" in said
