"""A practice whose criterion was missed is reported, and is a rule of exclusion."""

import json

import pytest
from command_line import call, output
from study_texts import TUTORIAL as CONSTANT_TUTORIAL

TUTORIAL = CONSTANT_TUTORIAL.replace("[60, 240]", "[240]")


@pytest.fixture
def study(tmp_path):
    """Write the tutorial with a practice at one level, and more tables."""

    def written(level, more=""):
        path = tmp_path / "mine.toml"
        practice = f"\n[practice]\nlevels = [{level}]\nn_correct = 3\nn_of = 3\nn_trials = 6\n"
        path.write_text(f"{TUTORIAL}{practice}{more}")
        return path

    return written


@pytest.mark.parametrize(("level", "is_missed"), [(-10.0, True), (39.9, False)])
def test_run_reports_missed_practice(study, tmp_path, capsys, level, is_missed):
    arguments = ("run", study(level), "--participant", "P01", "--rig", "simulated", "--seed", "3", "--out")
    _, _, said = call(capsys, *arguments, tmp_path / "data")
    assert ("the practice ended without meeting its criterion" in said) == is_missed


@pytest.mark.parametrize(("level", "is_missed"), [(-10.0, True), (39.9, False)])
def test_analyse_names_who_missed_practice(study, tmp_path, capsys, level, is_missed):
    arguments = ("simulate", study(level), "--participants", "2", "--seed", "3", "--out", tmp_path / "data")
    assert json.loads(output(capsys, *arguments, "--json"))["practice_missed"] == 2 * is_missed
    warnings = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))["warnings"]
    assert ("practice ended without meeting its criterion: P01, P02" in warnings) == is_missed


def test_exclusion_rule_leaves_out_who_missed_practice(study, tmp_path, capsys):
    path = study(24.0, "\n[analysis.exclusion]\npractice = true\n")
    output(capsys, "simulate", path, "--participants", "8", "--seed", "3", "--out", tmp_path / "data")
    found = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))
    (warned,) = [text for text in found["warnings"] if text.startswith("practice ended")]
    missed = warned.partition(": ")[2].split(", ")
    assert 0 < len(missed) < 8
    assert {row["participant"] for row in found["excluded"]} == set(missed)
    assert {row["rule"] for row in found["excluded"]} == {"practice"}
    assert not {row["participant"] for row in found["thresholds"]} & set(missed)
