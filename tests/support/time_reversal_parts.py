"""Small valid arguments for functions of time reversal."""

from pathlib import Path

import numpy as np

from tactometry.signal import Signal
from tactometry.stimuli.time_reversal import Band, FocusTrain, Plate, Responses, Screen, Setup, Target
from tactometry.stimuli.time_reversal.design.closed_forms import Reverberation
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.design.thickness import sheets
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.plate.modes import modes_of
from tactometry.stimuli.time_reversal.responses.load import Receptances
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.transducer import border

PLATE = Plate(0.297, 0.210, 1.1e-3, 64e9, 0.20, 2230.0, "SSSS")
SCREEN = Screen(PLATE, border(PLATE, 2), Attenuation(3e-3))
BAND = Band(100.0, 900.0)
RNG = np.random.default_rng(0)
DECAYING = np.exp(-np.arange(400) / 40) * RNG.standard_normal((2, 2, 400))
RESPONSES = Responses(1e-9 * DECAYING, 2e3)
FOCUS = RESPONSES.at_point(0)
SIGNAL = Signal(np.sign(RNG.standard_normal((2, 8))), 2e3, "V")
EMISSION = Emission(BAND, 5e-3, 2e3)
SETUP = Setup(n_transducers=2, rate_hz=4e3, modes_to_hz=1e3, tau_s=1e-3, learnt_s=2e-3)
TRAIN = FocusTrain(SETUP, f_max_hz=900.0, duration_s=0.1)
DESIGN = Design(PLATE, Transducers(8), Band(1e3, 20e3), 3e-3, 6e-3)
ROOM = Reverberation(32, 25e3, 3e-3, 6e-3, 18e-3)
GRID = (np.linspace(0, 0.297, 7), np.linspace(0, 0.21, 5))
BUMP = np.array([0.0, 1.0, 4.0, 1.0, 0.0])
LINE = np.arange(5.0)
FIELD = np.outer(BUMP, BUMP)
POINTS = [(0.1, 0.1), (0.2, 0.05)]
S = np.array([1.0 + 2j, 1.0 + 50j])
MODAL = SCREEN.modes(1e3)
WEIGHTS = np.ones((len(MODAL.frequency_hz), 1))
RECEPTANCES = Receptances.of(SCREEN.oscillators(1e3), 0.15, S)
SAMPLING = {"rate_hz": 2e3, "duration_s": 4e-3, "f_max_hz": 1e3}
LOW = {"f_max_hz": 1e3}
SHEETS = sheets(PLATE, Transducers(8), DESIGN.band, 3e-3, Target(), [1e-3])
FREE = modes_of(Plate(0.297, 0.210, 1.1e-3, 64e9, 0.20, 2230.0, "CFFF"), 500.0)
AT_SETUP = Signal(np.sign(RNG.standard_normal((2, 8))), 4e3, "V")
CLICK = np.eye(1, 400)[0]
PLATE_FILE = 'glass = "Borofloat 33"\nlength_m = 0.2\nwidth_m = 0.1\nthickness_m = 1e-3\nboundary = "SSSS"\n'


def written(folder: Path) -> tuple[Path, Path]:
    """Responses and a plate in files."""
    npz, toml = folder / "h.npz", folder / "plate.toml"
    np.savez(npz, samples=RESPONSES.samples, rate_hz=2e3)
    toml.write_text(PLATE_FILE)
    return npz, toml
