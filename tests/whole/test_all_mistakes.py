"""All mistakes of a file are reported in one run, one per line."""

from pathlib import Path

import pytest
from command_line import call
from study_texts import TUTORIAL

STUDY = TUTORIAL
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
BENCH_PLACES = [
    "output.ramp_s",
    "limits.voltage_peak_v",
    "speed",
    "screen.widht_m",
    "output.folder",
    "sensors.finger.kind",
]
SCENE_PLACES = ["titel", "outputs", "surface.thickness", "effects[0].kind", "contacts[0].force"]
MAP_PLACES = ["levl", "columns.participant", "decimal"]


def mistakes(capsys, *arguments) -> list[str]:
    """Return the places of the mistakes that a command prints."""
    code, said, _ = call(capsys, *arguments)
    assert (code, "Traceback" in said) == (2, False), said
    lines = said.splitlines()
    assert all(line.startswith("tactometry: ") for line in lines)
    return [line.partition(", ")[2].partition(": ")[0] for line in lines]


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A study with a mistake in each of its tables."""
    text = STUDY
    for right, wrong in {
        "trial_s = ": "trial_time_s = ",
        "title = ": "titel = ",
        "[factors]": "[plan]\nlongest = 3\n\n[factors]",
        'kind = "slide"': 'kind = "slip"',
        "repeats = ": "repeat = ",
        "catch_rate = 0.2": 'catch_rate = "often"',
        '"500 ms"': '"half a second"',
        "between_sd_db": "between_db",
    }.items():
        assert right in text
        text = text.replace(right, wrong, 1)
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_study_prints_all_its_mistakes(study, capsys) -> None:
    assert mistakes(capsys, "run", study, "--participant", "P01", "--rig", "simulated", "--dry-run") == [
        "stimulus.duration_s",
        "titel",
        "trial_time_s",
        "plan.longest",
        "task.catch_rate",
        "observer.between_db",
        "procedure.repeat",
        "touch.kind",
    ]


@pytest.mark.parametrize(
    ("command", "text", "places"),
    [
        (("check", "--bench"), BENCH, BENCH_PLACES),
        (("scene",), SCENE, SCENE_PLACES),
        (("analyse", "data.csv", "--columns"), MAP, MAP_PLACES),
    ],
    ids=["bench", "scene", "map"],
)
def test_file_prints_all_its_mistakes(tmp_path, capsys, command, text, places) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    assert mistakes(capsys, *command, path) == places
