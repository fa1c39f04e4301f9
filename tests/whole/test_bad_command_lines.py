"""Invalid command lines: one sentence, exit status, no changes."""

import re

import pytest
from command_line import assert_one_sentence, call

COMMAND_LINES = {
    "unknown command": (["runn"], 2, "found no command 'runn', expected one of .*; did you mean 'run'\\?"),
    "unknown option": (["simulate", "--sede", "1"], 2, "simulate: No such option '--sede'.*--seed.*"),
    "missing option": (["simulate", "tutorial"], 2, "simulate: Missing option '--participants'."),
    "missing argument": (["run"], 2, "run: Missing argument 'STUDY'."),
    "no number": (
        ["simulate", "tutorial", "--participants", "many", "--seed", "1", "--out", "d"],
        2,
        "simulate: Invalid value for '--participants': 'many' is not a valid integer.",
    ),
    "unknown study": (
        ["simulate", "tutorail", "--participants", "1", "--seed", "1", "--out", "d"],
        2,
        "tutorail: found no such file or built-in study, expected .*; did you mean 'tutorial'\\?",
    ),
    "no participants": (
        ["simulate", "tutorial", "--participants", "0", "--seed", "1", "--out", "d"],
        2,
        "--participants: found 0, expected at least 1",
    ),
    "negative seed": (
        ["simulate", "tutorial", "--participants", "1", "--seed", "-1", "--out", "d"],
        2,
        "--seed: found -1, expected a whole number, at least 0",
    ),
    "no jobs": (
        ["simulate", "tutorial", "--participants", "1", "--seed", "1", "--out", "d", "--jobs", "0"],
        2,
        "--jobs: found 0, expected at least 1, or -1 for all cores",
    ),
    "name for a code": (
        ["run", "tutorial", "--participant", "Anna K.", "--rig", "simulated", "--out", "d"],
        2,
        "participant: found 'Anna K.', expected a code of 1 to 32 letters and digits .*, but not a name or a path",
    ),
    "path for a code": (
        ["run", "tutorial", "--participant", "../../etc", "--rig", "simulated", "--out", "d"],
        2,
        "participant: found '../../etc', expected a code of .*",
    ),
    "code without number": (
        ["run", "tutorial", "--participant", "AK", "--rig", "simulated", "--out", "d"],
        2,
        "participant 'AK': found no number from 1 for counterbalancing, .*; or state --number",
    ),
    "code without number, to go on": (
        ["run", "tutorial", "--participant", "AK", "--rig", "console", "--out", "d", "--resume"],
        2,
        "participant 'AK': found no number from 1 for counterbalancing, .*; or state --number",
    ),
    "session 0": (
        ["run", "tutorial", "--participant", "P01", "--session", "0", "--rig", "simulated", "--out", "d"],
        2,
        "session: found 0, expected a number from 1",
    ),
    "unknown rig": (
        ["run", "tutorial", "--participant", "P01", "--rig", "benhc"],
        2,
        "run: Invalid value for '--rig': 'benhc' is not one of 'bench', 'console', 'simulated'.",
    ),
    "no bench file": (
        ["run", "tutorial", "--participant", "P01", "--bench", "none.toml", "--out", "d"],
        2,
        "none.toml: cannot be read .*, expected a bench file",
    ),
    "nothing to replay": (["replay", "."], 2, ".: found no journal, expected a data set with journals/.*"),
    "nothing to validate": (
        ["validate", "nowhere"],
        2,
        "nowhere: found no such folder or file, expected a data set .*",
    ),
    "nothing to analyse": (
        ["analyse", "nowhere"],
        2,
        "nowhere: no such file or folder, expected a data set or a CSV file of trials",
    ),
    "unknown built-in": (["new", "nothing"], 2, "nothing: found no such file or built-in study, expected .*"),
}


@pytest.mark.parametrize("line", COMMAND_LINES)
def test_bad_command_line_raises_one_sentence_error(tmp_path, capsys, monkeypatch, line):
    arguments, expected, message = COMMAND_LINES[line]
    monkeypatch.chdir(tmp_path)
    status, said, _ = call(capsys, *arguments)
    assert_one_sentence(said)
    assert re.fullmatch(f"tactometry: {message}", said), said
    assert status == expected
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_not_overwritten(tmp_path, capsys):
    mine = tmp_path / "mine.toml"
    mine.write_text("precious")
    status, said, _ = call(capsys, "new", "tutorial", "--out", mine)
    assert (status, said) == (
        2,
        f"tactometry: {mine}: found an existing file, expected a new file; choose another --out",
    )
    assert mine.read_text() == "precious"
