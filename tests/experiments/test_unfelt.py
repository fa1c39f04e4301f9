"""Studies with stimuli that are predicted to be imperceptible."""

import json

import pytest
from command_line import call, output
from study_texts import TUTORIAL, changed

AT_60_HZ = ["frequency_hz 60, force_n 0.5", "frequency_hz 60, force_n 1"]
AT_240_HZ = ["frequency_hz 240, force_n 0.5", "frequency_hz 240, force_n 1"]
FORCED_CHOICE = {
    "frequency_hz = [60, 240]": "frequency_hz = [60, 240]\nforce_n = [0.5, 1.0]",
    "force_n = 1.0\n": "",
    'kind = "yes_no"\ncatch_rate = 0.2': 'kind = "forced_choice"\nn_intervals = 2',
    "repeats = 4": "repeats = 10",
}
WEAK = changed(TUTORIAL.partition("\n[observer]")[0], FORCED_CHOICE)


@pytest.fixture
def weak(tmp_path):

    def written(levels):
        path = tmp_path / "weak.toml"
        path.write_text(changed(WEAK, {"[22, 28, 34, 40]": str(levels)}))
        return path

    return written


@pytest.mark.parametrize(
    ("levels", "conditions"), [([24, 28, 32, 36], AT_60_HZ), ([28, 32, 36, 40], []), ([4, 13], [*AT_60_HZ, *AT_240_HZ])]
)
def test_dry_run_warns_of_each_condition_below_threshold(weak, capsys, levels, conditions):
    said = output(capsys, "run", weak(levels), "--participant", "P01", "--dry-run").splitlines()
    warned = [line.partition(" threshold at ")[2] for line in said if line.startswith("WARNING: ")]
    assert warned == conditions


def test_simulate_warns_of_condition_below_threshold(weak, tmp_path, capsys):
    arguments = ("simulate", weak([24, 36]), "--participants", "1", "--seed", "1", "--out", tmp_path / "data", "--json")
    found = json.loads(output(capsys, *arguments))["unfelt"]
    assert [row["condition"] for row in found] == AT_60_HZ
    assert found[0]["sensation_db"] == pytest.approx(-7.9, abs=0.1)


def test_simulate_predicts_by_stated_threshold(weak, tmp_path, capsys):
    path = weak([4, 13])
    observer = "\n[observer]\nkind = 'psychometric'\nthreshold = 10.0\nwidth = 8.0\n"
    path.write_text(path.read_text() + observer + "conditions = [{ frequency_hz = 240, threshold = 20.0 }]\n")
    arguments = ("simulate", path, "--participants", "1", "--seed", "1", "--out", tmp_path / "data", "--json")
    assert [row["condition"] for row in json.loads(output(capsys, *arguments))["unfelt"]] == AT_240_HZ


def test_check_warns_of_condition_below_threshold(weak, tmp_path, capsys):
    code, _, out = call(capsys, "check", weak([24, 36]), "--out", tmp_path, "--json")
    lines = [row["found"] for row in json.loads(out)["findings"] if row["what"] == "not felt"]
    assert code != 0
    assert [line.partition(" threshold at ")[2] for line in lines] == AT_60_HZ


@pytest.mark.parametrize("levels", [[4, 7, 10, 13], [24, 28, 32, 36]])
def test_analyse_prints_no_internal_message(weak, tmp_path, capsys, levels):
    output(capsys, "simulate", weak(levels), "--participants", "6", "--seed", "1", "--out", tmp_path / "data")
    outcome = json.loads(output(capsys, "analyse", tmp_path / "data", "--json"))
    notes = [note for found in outcome["outcomes"] for note in found["notes"]]
    sentences = [line for check in outcome["hierarchical"] for line in check["sentences"]]
    assert "no mixed model: the known values do not determine the estimates" in notes
    assert not [line for line in (*notes, *sentences) if "found " in line or "expected " in line]
