"""A dry run refuses what the session refuses, with the same error."""

import pytest
from command_line import call
from PIL import Image
from study_texts import TUTORIAL, changed

from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.rehearsal import page_images
from tactometry.experiments.study.study_file import load
from tactometry.provenance import sha256

RECORDED_FORCE = """
[sensors.hand]
kind = "recorded"
path = "force.csv"
rate_hz = 1000
[force]
sensor = "hand"
newtons_per_count = 0.01
"""
WAV = """
[stimulus]
kind = "wav"
path = "missing.wav"
sha256 = ""
rate_hz = "48 kHz"
duration_s = "500 ms"
level_unit = "dB re 1 V"
"""
NEEDS = {
    "responses": ("time-reversal-threshold", '[time_reversal]\nresponses = "none.npz"\n', "none.npz"),
    "recording": ("tutorial", RECORDED_FORCE, "force.csv: cannot be read as a recording"),
    "wav": ("wav.toml", "", "missing.wav"),
    "image": ("image.toml", "", "missing.png"),
    "format": ("tutorial", '[output]\nkind = "file"\nfolder = "played"\nrate_hz = 8000\n', "8000"),
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "image.toml").write_text(f'{TUTORIAL}\n[images.welcome]\npath = "missing.png"\nsha256 = "{"0" * 64}"\n')
    stimulus = TUTORIAL[TUTORIAL.index("[stimulus]") : TUTORIAL.index("[touch]")]
    changes = {"frequency_hz = [60, 240]": "force_n = [0.5, 1.0]", "force_n = 1.0\n": "", stimulus: WAV}
    (tmp_path / "wav.toml").write_text(changed(TUTORIAL, dict(reversed(changes.items()))))
    return tmp_path


@pytest.mark.parametrize("need", NEEDS)
def test_dry_run_refuses_as_session_does(here, capsys, need):
    study, bench, part = NEEDS[need]
    (here / "bench.toml").write_text(bench)
    words = ("run", study, "--participant", "P01", "--bench", "bench.toml")
    rig = "bench" if need == "image" else "console"
    dry = call(capsys, *words, "--rig", rig, "--dry-run")
    assert dry[:2] == call(capsys, *words, "--rig", rig)[:2]
    assert dry[0] in (2, 3)
    assert part in dry[1]
    assert not (here / "played").exists()


def test_dry_run_checks_own_code_of_simulated_participant(here, capsys):
    tutorial = TUTORIAL.partition("\n[observer]")[0]
    (here / "own.toml").write_text(f'{tutorial}\n[observer]\nkind = "mine:Guesser"\nbias = 0.9\n')
    words = ("run", "own.toml", "--participant", "P01", "--rig", "simulated")
    dry = call(capsys, *words, "--dry-run")
    assert dry[:2] == call(capsys, *words)[:2]
    assert (dry[0], "--allow-code" in dry[1]) == (2, True)


def test_image_is_found_next_to_study(here, monkeypatch):
    (here / "elsewhere").mkdir()
    monkeypatch.chdir(here / "elsewhere")
    Image.new("L", (2, 1)).save(here / "tone.png")
    digest = sha256((here / "tone.png").read_bytes())
    study = (here / "image.toml").read_text("utf-8").replace("missing.png", "tone.png").replace("0" * 64, digest)
    (here / "image.toml").write_text(study)
    images = page_images(wire(load("../image.toml")[0], "../image.toml"))
    assert images["welcome"].path == str(here / "tone.png")
