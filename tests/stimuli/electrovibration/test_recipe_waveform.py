"""A custom waveform, added as CONTRIBUTING describes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from study_texts import TUTORIAL

FILE = '''
"""A sawtooth, as it would stand in stimuli/electrovibration/waveforms/sawtooth.py."""

from dataclasses import dataclass

from tactometry.stimuli.electrovibration.waveforms.pieces import Corners
from tactometry.stimuli.electrovibration.waveforms.periodic import Periodic
from tactometry.stimuli.electrovibration.waveforms.waveform import LevelUnit


@dataclass(frozen=True)
class Sawtooth(Periodic):
    frequency_hz: float
    duration_s: float = 1.0
    ramp_s: float = 0.05
    rate_hz: float = 20_000.0
    band_limited: bool = False
    level_unit: LevelUnit = "dB re 1 V"

    @property
    def corners(self) -> Corners:
        return Corners((0.0, 0.5, 0.5, 1.0), (0.0, 1.0, -1.0, 0.0))
'''

LINE = """
import json, sys
from tactometry.stimuli.electrovibration.waveforms import kinds

kinds.WAVEFORMS["sawtooth"] = kinds.WaveformKind("sawtooth:Sawtooth", {"frequency_hz": 60.0})  # the line

from catalogue import STIMULI
from tactometry.cli import main
from tactometry.experiments.reference.tables import tables

said = {"keys": list(tables()), "laws": list(STIMULI), "status": []}
for arguments in json.loads(sys.argv[1]):
    try:
        main(arguments)
    except SystemExit as ended:
        said["status"].append(ended.code)
print(json.dumps(said), file=sys.stderr)
"""


@pytest.fixture(scope="module")
def added(tmp_path_factory):
    """Return what a new process prints after loading the waveform."""
    folder = tmp_path_factory.mktemp("sawtooth")
    (folder / "sawtooth.py").write_text(FILE)
    study = TUTORIAL.replace('kind = "amplitude_modulated"', 'kind = "sawtooth"')
    (folder / "good.toml").write_text(study)
    (folder / "mistyped.toml").write_text(study.replace('"sawtooth"', '"sawtoth"'))
    data = str(folder / "d")
    commands = [
        ["simulate", str(folder / "good.toml"), "--participants", "1", "--seed", "1", "--out", data],
        ["validate", data],
        ["replay", data],
        ["run", str(folder / "mistyped.toml"), "--participant", "P01", "--dry-run"],
    ]
    tests = Path(__file__).parents[2]
    path = os.pathsep.join(map(str, (folder, tests, tests / "support")))
    return subprocess.run(
        [sys.executable, "-c", LINE, json.dumps(commands)],
        capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": path},
    ).stderr.splitlines()  # fmt: skip


def test_custom_waveform_study_simulates_validates_and_replays(added):
    assert json.loads(added[-1])["status"] == [0, 0, 0, 2]


def test_custom_waveform_appears_in_keys_and_laws(added):
    output = json.loads(added[-1])
    assert "stimulus.sawtooth" in output["keys"]
    assert "sawtooth" in output["laws"]


def test_mistyped_custom_waveform_name_is_reported(added):
    assert "did you mean 'sawtooth'" in " ".join(added[:-1])
