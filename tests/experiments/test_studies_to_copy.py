"""Example studies rehearsed, simulated, validated, replayed, analysed."""

import pytest
from command_line import output, status

from tactometry.experiments.study.study_file import builtin, load, shipped

TO_COPY = sorted(set(shipped()) - set(builtin()))
SAYS = {
    "masking-on-a-hybrid-surface": "threshold, dB re 1 um",
    "own-patterns-attrakdiff": "ATT: click: F(",
    "preferred-texture": "preference (Bradley-Terry worths",
    "texture-discrimination": "just noticeable difference, dB",
    "threshold-by-adjustment": "setting by adjustment, dB re 1 V",
    "two-interval-forced-choice": "threshold, dB re 1 V",
}
"""What an analysis of each begins with."""


@pytest.fixture(scope="module", params=TO_COPY)
def copied(request, tmp_path_factory):
    root = tmp_path_factory.mktemp(request.param)
    assert status("new", request.param, "--out", root / "mine.toml") == 0
    arguments = ("simulate", root / "mine.toml", "--participants", "3", "--seed", "1", "--out", root / "data")
    assert status(*arguments) == 0
    return request.param, root


def test_all_six_studies_have_expected_results():
    assert list(SAYS) == TO_COPY


@pytest.mark.parametrize("name", TO_COPY)
def test_study_head_states_purpose_and_command(name):
    study, content = load(name)
    comments = [line for line in content.decode().splitlines() if line.startswith("#")]
    assert study.name == name
    assert any(line.startswith(f"# Try it:  tactometry simulate {name} --participants") for line in comments)


def test_example_study_is_rehearsed(copied, capsys):
    said = output(capsys, "run", copied[1] / "mine.toml", "--participant", "P01", "--dry-run")
    assert "without repeated trials" in said


@pytest.mark.parametrize("command", ["validate", "replay"])
def test_example_study_data_are_valid(copied, capsys, command):
    output(capsys, command, copied[1] / "data")


def test_example_study_analysis_has_expected_result(copied, capsys):
    name, root = copied
    assert SAYS[name] in output(capsys, "analyse", root / "data", "--report", root / "report.html")
    report = (root / "report.html").read_text("utf-8")
    assert len(report) > 10_000
    assert ("For comparisons, unlike the fits of single participants" in report) == (name == "texture-discrimination")
