"""Valid arguments of every public function of time reversal."""

import importlib
import inspect
import pkgutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

import tactometry.stimuli.time_reversal as package
from tactometry.contact import Contact
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import Demand, Effect
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal
from tactometry.stimuli.time_reversal import (
    Band,
    DiscPatch,
    Fingertip,
    FocusTrain,
    Glass,
    Pattern,
    Plate,
    Responses,
    Screen,
    Setup,
    Target,
    TimeReversalStimulus,
)
from tactometry.stimuli.time_reversal.design.closed_forms import Reverberation
from tactometry.stimuli.time_reversal.design.guide import Design, Transducers
from tactometry.stimuli.time_reversal.design.thickness import sheets
from tactometry.stimuli.time_reversal.filters import Butterworth
from tactometry.stimuli.time_reversal.finger import Contactor
from tactometry.stimuli.time_reversal.focus_loss import FocusLoss
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pattern import Exponential, RaisedCosine, Rectangular, Sinc, Table
from tactometry.stimuli.time_reversal.focusing.pulse_width import PulseWidth
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.plate.modes import modes_of
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, Receptances, SprungMass
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.transducer import Patch, PointForce, border
from tactometry.stimuli.time_reversal.stimulus.placed_foci import Place, PlacedFoci
from tactometry.stimuli.time_reversal.stimulus.sensation import FocusReading

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
    npz, toml = folder / "h.npz", folder / "plate.toml"
    np.savez(npz, samples=RESPONSES.samples, rate_hz=2e3)
    toml.write_text(PLATE_FILE)
    return npz, toml


PLACES = {"index": Place(0.10), "middle": Place(0.13)}
INSTANCES = (
    Attenuation(3e-3), Fingertip(), Tissue(), PulpLoad(0.1, 0.1, 6e-3), FocusLoss(S, 0.1 * S, 0.1 * S),
    Contactor("rigid"), TimeReversalStimulus(FOCUS), TRAIN, EMISSION, Glass("x", 64e9, 0.2, 2230.0, "here"),
    PlateLoad(0.1, 0.1, 9.0), SprungMass(0.1, 0.1, 1e-3, 1e5), RECEPTANCES, MODAL, FREE, Rectangular(), RaisedCosine(),
    Exponential(), Sinc(), Table((0.0, 1.0)), PLATE, Analogue(), OneBit(), SigmaDelta(), PulseWidth(200.0), RESPONSES,
    SCREEN, PlacedFoci(SETUP, f_max_hz=900.0, places=PLACES, place="index + middle"), Place(0.1), FocusReading(SETUP),
    SETUP, BAND, Butterworth(500.0), PointForce(0.1, 0.1), Patch(0.1, 0.1, 0.01, 0.01), DiscPatch(0.1, 0.1, 0.01),
)  # fmt: skip
SELF = {type(each).__name__: each for each in INSTANCES}
"""The instances of the methods."""

USUAL: Mapping[str, Any] = {
    "alpha": 1.25, "among": np.ones((2, 1, 1), complex), "amplitude_m": 1e-5, "amplitudes_m": BUMP, "apart": 2,
    "area_m2": 1e-4, "at": WEIGHTS, "at_m": (0.1, 0.1), "back": BUMP, "band": BAND, "boundary": "SSSS",
    "channel_capacitance_f": 1e-9, "channels": [1], "contact": Contact(2.0), "contact_m": 0.01,
    "contactors": [Contactor("finger")], "contributions": FIELD, "cutoff_hz": 100.0, "delay_s": [1e-3, 2e-3],
    "demand": Demand(TimeReversal(), (), (), (), 0.1), "design": DESIGN, "displacement_m": BUMP, "distance_m": 0.3,
    "duration_s": 0.1, "emission": EMISSION, "energy": np.exp(-np.arange(32.0) / 5), "f_max_hz": 1e3,
    "f_mean_hz": [1e3], "f_min_hz": 100.0, "field_m": FIELD, "finger": Fingertip(), "fingers": ("index",),
    "flank_hz": 50.0, "foci": RESPONSES, "focus": (0.1, 0.1), "force_n": 2.0, "forces_n": [2.0], "free_m": BUMP[None],
    "frequency_hz": 1e3, "full_scale": 1.0, "gain": Butterworth(500.0), "glass": "soda-lime", "grid_m": (LINE, LINE),
    "heard": SETUP.responses_at(0.1, 0.1), "height": 1.0, "index": 1, "inset_m": 0.012, "kelvin": 5.0,
    "learnt": RESPONSES, "length_m": 0.2, "level": 0.5, "loads": [PlateLoad(0.1, 0.1, 9.0)], "loss_tangent": 0.017,
    "mass_kg": 0.15, "modes": MODAL, "modulation": "burst", "modulus_pa": 1e9, "moment_n_per_v": 1e-3,
    "n_channels": np.array([8.0]), "n_draws": 2, "n_reversal": 9, "n_samples": 9, "n_transducers": 4, "n_x": 3,
    "n_y": 4, "name": "source", "of": WEIGHTS, "on_x": lambda axis: axis.value(0.1),
    "on_y": lambda axis: axis.value(0.1), "order": 4, "oscillators": SCREEN.oscillators(1e3), "path": [0, 1],
    "pattern": Pattern(10.0, 0.2), "peaks_m": [1e-5, 2e-5], "per_channel": True, "place": "index", "places": PLACES,
    "plate": PLATE, "played": CLICK, "point": 1, "points": POINTS, "position": np.array([0.0, 0.5]), "profile": BUMP,
    "provenance": {"who": "me"}, "pulp_mass_kg": 1e-4, "quantiser": OneBit(), "quantity": "velocity",
    "radius_m": 6e-3, "rate_hz": 2e3, "recorded": CLICK, "reference_m": 1e-5, "regularisation": 1e-6,
    "relative_permittivity": 1800.0, "relearn": False, "repetition_s": 3e-3, "response": CLICK,
    "responses": RESPONSES, "reversal_s": 0.1, "rng": np.random.default_rng(0), "room": ROOM, "rows": [0, 1, 0], "s": S,
    "sample": 7, "samples": [3, 7],
    "screen": SCREEN, "setup": SETUP, "shear_factor": 0.8, "shift_per_k": -5e-5, "side_m": 1e-2,
    "signal": SIGNAL, "signal_m": DECAYING[0, 0], "size": 4, "snr_db": 20.0, "sound_speed_m_per_s": 343.0,
    "sources": SCREEN.sources, "start_s": 0.01, "static_to_hz": 2e3, "stiffness": S[:, None],
    "subsets": {"all": [0, 1]}, "target": Target(), "tau_s": 3e-3, "there": LINE, "thickness_m": 1e-3,
    "thicknesses_m": [1e-3], "times_s": [0.0, 0.01], "tissue": Tissue(), "to": WEIGHTS,
    "to_contacts": np.ones((1, 1, 2), complex), "train": TRAIN, "transducers": Transducers(8), "voltage_v": 30.0,
    "wanted_resolution_m": 1e-2, "waveform": FIELD, "wavenumber_rad_per_m": [100.0], "weight": 0.5,
    "weights": [1.0, -1.0], "where": "fingers", "width_m": 0.1, "window": np.ones(400), "x": BUMP, "x_m": [0.1],
    "y_m": [0.1],
}  # fmt: skip
"""Values by the name of the parameter."""

ON_GRID = {"x_m": GRID[0], "y_m": GRID[1]}
ON_PATTERN = {"frequency_hz": np.array([0.0, 50.0])}
INSIDE = {"x_m": 0.1, "y_m": 0.1}
OTHER: Mapping[str, Mapping[str, Any]] = {
    "Attenuation.rate_per_s": {"frequency_hz": [1e3]}, "one_bit_amplitude_ratio": {"reversal_s": [6e-3]},
    "analogue_amplitude_ratio": {"reversal_s": [6e-3]}, "repetition_noise_ratio": {"repetition_s": [5e-3]},
    "repetition_amplitude_ratio": {"reversal_s": 6e-3}, "focus_profile": {"radius_m": [0.0, 0.1]},
    "Fingertip.contact": {"self": Fingertip(impedance="tissue")}, "PulpLoad.check": {"name": "x"},
    "disc_stiffness": {"path": 2.0}, "FocusLoss.by": {"stiffness": S},
    "focus_loss": {"contact": PulpLoad(0.1, 0.1, 6e-3)},
    "force_loss": {"places": {"F": (0.1, 0.1)}}, "amplitude_loss": {"loads": [PlateLoad(0.2, 0.1, 9.0)]},
    "ejection_force_n": {"frequency_hz": 1e4}, "hertz_stiffness_n_per_m": {"force_n": 1.0, "radius_m": 1e-3},
    "one_sided_contacts": {"force_n": [1.0], "rate_hz": 1e4}, "one_sided_contact": {"free_m": BUMP, "rate_hz": 1e4},
    "tau_s": {"response": DECAYING[0, 0]},
    "recommend": {"band": DESIGN.band, "target": Target(1e-2, 5.0, 1e-6, 200.0)},
    "design.guide.amplitudes_m": {"reversal_s": np.array([1e-3])}, "contrast_over": {"reversal_s": np.array([1e-3])},
    "TimeReversalStimulus.at": {"level": 1e-9}, "TimeReversalStimulus.voltage_v": {"level": 1e-9},
    "FocusTrain.at": {"level": -60.0}, "FocusTrain.voltage_v": {"level": -60.0},
    "reversed_waveform": {"reversal_s": 0.2}, "drive": {"reversal_s": 0.2}, "sweep": {"f_max_hz": 900.0},
    "learn": {"recorded": DECAYING[0]}, "as_displacement": {"f_max_hz": 900.0},
    "loaded_responses": SAMPLING, "impulse_responses": {**SAMPLING, "quantity": "displacement"},
    "merit.field": {"at_m": GRID}, "movie": {"at_m": GRID}, "resolution_per_focus_m": {"foci": [(0.14, 0.1)]},
    "contrast_whole_of": {"amplitude_m": 4.0}, "merit.width_m": {"at_m": LINE},
    "SeparableModes.field": {"amplitude": np.ones(len(MODAL.frequency_hz)), **ON_GRID},
    "RitzModes.field": {"amplitude": np.ones(len(FREE.frequency_hz)), **ON_GRID},
    "SeparableModes.frame": ON_GRID, "RitzModes.frame": ON_GRID, "pattern_drive": {"tau_s": 3e-2},
    "burst_s": {"reversal_s": 7e-3, "tau_s": 3.5e-3}, "Plate.contains": INSIDE, "Plate.check_holds": {"name": "at_m"},
    "Responses.mean_of": {"points": [1]}, "samples_in": {"name": "duration_s", "duration_s": 1.0},
    "PlacedFoci.heard": {"learnt": None}, "Place": INSIDE, "PlacedFoci": {"f_max_hz": 900.0},
    "contact_force_n": {"signal": AT_SETUP}, "contact_forces_n": {"signal": AT_SETUP},
    "FocusReading.sensation_db": {"signal": AT_SETUP},
    "FocusReading.contact_force_n": {"signal": AT_SETUP}, "displacement_at_focus_m": {"signal": AT_SETUP},
    "free_displacement": {"signal": AT_SETUP}, "place_on": INSIDE, "events": {"rate_hz": 1e3},
    "Setup.responses_at": INSIDE, "Setup.responses_at_each": {"places": ((0.1, 0.1), (0.2, 0.1))},
    "a_weighting_db": {"frequency_hz": [1e3]}, "envelope": {"signal": BUMP}, "filtered": {"samples": FIELD},
    "Band.at": ON_PATTERN, "Butterworth.at": ON_PATTERN,
    "sheets": {"band": DESIGN.band}, "best_sheet": {"among": SHEETS},
    "capacitance_f": {"thickness_m": 3e-4}, "border": {"side_m": 0.01},
}  # fmt: skip
"""Values of single functions."""
ONLY = {"PlacedFoci": ("setup", "places", "place", "f_max_hz")}
"""Functions whose other arguments keep their defaults."""

INNER = {
    *("plate.rectangle", "plate.dispersion.frequencies_rad_per_s", "plate.modal_sum", "plate.propagator"),
    *("plate.oscillators", "plate.ritz", "focusing.modulator", "focusing.bursts"),
}
"""Modules and functions whose arguments are arrays that the public functions make."""
CLASSES = {"NamedGlass", "Place", "PlacedFoci", "FingersSensation"}
"""Classes that are called with values of their own."""
ALSO = {"focusing.pulse_width": ["PulseWidth.size"], "plate.modes": ["SeparableModes.field", "RitzModes.field"]}
"""Methods of effects, and methods that classes inherit."""


def names_of(inner: str, module: ModuleType) -> Iterator[str]:
    """Return the public functions of a module, and the methods of its classes of which there is an instance."""
    for name, thing in vars(module).items():
        if name.startswith("_") or f"{inner}.{name}" in INNER or getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(thing) or name in CLASSES:
            yield name
        members = vars(thing).items() if name in SELF else ()
        yield from (f"{name}.{member}" for member, method in members if _is_public(member, method))


def _is_public(name: str, member: object) -> bool:
    is_method = inspect.isfunction(member) or isinstance(member, classmethod)
    return is_method and not (name.startswith("_") or hasattr(Effect, name))


def calls(folder: Path) -> Mapping[str, Mapping[str, Any]]:
    """Valid arguments of every public function, by module; `self` is the instance of a method."""
    npz, toml = written(folder)
    files = {"read_plate": toml, "write_learnt": folder / "learnt.npz", "read_provenance": npz}
    found = {}
    for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        inner = info.name.removeprefix(f"{package.__name__}.")
        if not (info.ispkg or inner.startswith("figures") or inner in INNER):
            names = [*names_of(inner, importlib.import_module(info.name)), *ALSO.get(inner, ())]
            found[inner] = {name: _arguments(inner, name, files | {"paths": [npz]}) for name in names}
    return found


def _arguments(module: str, name: str, files: Mapping[str, Any]) -> Mapping[str, Any]:
    other = next((values for key, values in OTHER.items() if f".{module}.{name}".endswith(f".{key}")), {})
    kind, _, method = name.rpartition(".")
    found = {"self": other.get("self", SELF[kind])} if kind else {}
    owner = found.get("self", importlib.import_module(f"{package.__name__}.{module}"))
    values = {**USUAL, "paths": files["paths"], **other}
    if name in files:
        values["path"] = files[name]
    parameters = ONLY.get(name, inspect.signature(getattr(owner, method)).parameters)
    return found | {parameter: values[parameter] for parameter in parameters if parameter in values}
