"""Invalid command lines give one sentence, files with mistakes one for each; exit status 2, no changes."""

import re

import pytest
from command_line import assert_one_sentence, call
from study_texts import TUTORIAL, changed

SIMULATE = "simulate tutorial --participants 1 --seed 1 --out d"
RUN = "run tutorial --participant P01 --rig simulated --out d"
COMMAND_LINES = [
    ("runn", r"found no command 'runn', expected one of .*; did you mean 'run'\?"),
    ("simulate --sede 1", r"simulate: No such option '--sede'.*--seed.*"),
    ("simulate tutorial", r"simulate: Missing option '--participants'\."),
    ("run", r"run: Missing argument 'STUDY'\."),
    (f"{SIMULATE} --participants many", r"simulate: Invalid value for '--participants': 'many' is not a valid"),
    (SIMULATE.replace("tutorial", "tutorail"), r"tutorail: found no such file .*; did you mean 'tutorial'\?"),
    (f"{SIMULATE} --participants 0", "--participants: found 0, expected at least 1"),
    (f"{SIMULATE} --seed -1", "--seed: found -1, expected a whole number, at least 0"),
    (f"{SIMULATE} --jobs 0", "--jobs: found 0, expected at least 1, or -1 for all cores"),
    (f"{RUN} --participant A-K.", r"participant: found 'A-K.', expected a code of .*, but not a name or a path"),
    (f"{RUN} --participant ../../etc", r"participant: found '\.\./\.\./etc', expected a code of 1 to 32 letters and"),
    (f"{RUN} --participant AK", "participant 'AK': found no number from 1 for counterbalancing, .*; or state --number"),
    (f"{RUN} --participant AK --rig console --resume", "participant 'AK': found no number from 1 for .*"),
    (f"{RUN} --session 0", "session: found 0, expected a number from 1"),
    (f"{RUN} --rig benhc", r"run: Invalid value for '--rig': 'benhc' is not one of 'bench', 'console', 'simulated'\."),
    (f"{RUN} --rig bench --bench none.toml", r"none\.toml: cannot be read .*, expected a bench file"),
    ("replay .", r"\.: found no journal, expected a data set with journals/.*"),
    ("validate nowhere", "nowhere: found no such folder or file, expected a data set .*"),
    ("analyse nowhere", "nowhere: no such file or folder, expected a data set or a CSV file of trials"),
    ("new nothing", "nothing: found no such file or built-in study, expected .*"),
]


@pytest.mark.parametrize(("line", "message"), COMMAND_LINES)
def test_bad_command_line_raises_one_sentence_error(tmp_path, capsys, monkeypatch, line, message):
    monkeypatch.chdir(tmp_path)
    status, said, _ = call(capsys, *line.split())
    assert_one_sentence(said)
    assert re.match(f"tactometry: {message}", said), said
    assert status == 2
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_not_overwritten(tmp_path, capsys):
    mine = tmp_path / "mine.toml"
    mine.write_text("precious")
    status, said, _ = call(capsys, "new", "tutorial", "--out", mine)
    assert (status, said.partition(": ")[2]) == (
        2, f"{mine}: found an existing file, expected a new file; choose another --out"
    )  # fmt: skip
    assert mine.read_text() == "precious"


# --- all mistakes of a file, one per line

BENCH = """
speed = 3
[screen]
widht_m = 0.3
[output]
kind = "file"
ramp_s = "slow"
[limits]
voltage_peak_v = "much"
[sensors.finger]
kind = "nose"
"""
SCENE = """
titel = "a"
outputs = "voltage_v"
[surface]
kind = "electrovibration"
frequency_hz = "240 Hz"
thickness = 3
[[effects]]
kind = "none"
[[contacts]]
force = 2
"""
MAP = """
levl = "x"
[columns]
participant = 3
[decimal]
"""
STUDY = {
    "trial_s = ": "trial_time_s = ",
    "title = ": "titel = ",
    "[factors]": "[plan]\nlongest = 3\n\n[factors]",
    'kind = "slide"': 'kind = "slip"',
    "repeats = ": "repeat = ",
    "catch_rate = 0.2": 'catch_rate = "often"',
    '"500 ms"': '"half a second"',
    "between_sd_db": "between_db",
}
CASES = {
    "study": (
        ("run", "--participant", "P01", "--rig", "simulated", "--dry-run"),
        changed(TUTORIAL, STUDY),
        "stimulus.duration_s titel trial_time_s plan.longest task.catch_rate observer.between_db procedure.repeat "
        "touch.kind",
    ),
    "bench": (
        ("check", "--bench"),
        BENCH,
        "output.ramp_s limits.voltage_peak_v speed screen.widht_m output.folder sensors.finger.kind",
    ),
    "scene": (("scene",), SCENE, "titel outputs surface.thickness effects[0].kind contacts[0].force"),
    "map": (("analyse", "data.csv", "--columns"), MAP, "levl columns.participant decimal"),
}
"""A command, its file with a mistake in each table, and the places of the mistakes."""


@pytest.mark.parametrize("name", CASES)
def test_file_prints_all_its_mistakes(tmp_path, capsys, name) -> None:
    command, text, places = CASES[name]
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    code, said, _ = call(capsys, *command, path)
    assert (code, "Traceback" in said) == (2, False), said
    lines = said.splitlines()
    assert all(line.startswith("tactometry: ") for line in lines)
    assert [line.partition(", ")[2].partition(": ")[0] for line in lines] == places.split()
