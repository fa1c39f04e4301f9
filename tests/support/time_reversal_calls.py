"""A valid call of every public function, class and method of time reversal.

Arguments are found by the names of parameters, which hold their quantity and unit.
"""

import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import is_dataclass
from inspect import isfunction
from pathlib import Path
from typing import Any

import numpy as np
from hostile import Call, call_of, methods, valid_arguments
from time_reversal_parts import (
    AT_SETUP,
    BAND,
    BUMP,
    CLICK,
    DECAYING,
    DESIGN,
    EMISSION,
    FIELD,
    FOCUS,
    FREE,
    GRID,
    LINE,
    MODAL,
    PLATE,
    POINTS,
    RECEPTANCES,
    RESPONSES,
    ROOM,
    SCREEN,
    SETUP,
    SHEETS,
    SIGNAL,
    TRAIN,
    WEIGHTS,
    S,
    written,
)

import tactometry.stimuli.time_reversal as package
from tactometry.contact import Contact
from tactometry.stimuli.time_reversal import (
    DiscPatch,
    Fingertip,
    Glass,
    Pattern,
    Target,
    TimeReversalSensation,
    TimeReversalStimulus,
)
from tactometry.stimuli.time_reversal.design.guide import Transducers
from tactometry.stimuli.time_reversal.filters import Butterworth
from tactometry.stimuli.time_reversal.finger import Contactor
from tactometry.stimuli.time_reversal.focus_loss import FocusLoss
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pattern import Exponential, RaisedCosine, Rectangular, Sinc, Table
from tactometry.stimuli.time_reversal.focusing.pulse_width import PulseWidth
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import NoiseSpectrum
from tactometry.stimuli.time_reversal.plate.glass import NamedGlass
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue
from tactometry.stimuli.time_reversal.responses.learning import Excitation
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, SprungMass
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.glass_panel import GlassPanel
from tactometry.stimuli.time_reversal.screen.transducer import Patch, PointForce
from tactometry.stimuli.time_reversal.stimulus.placed_foci import FingersSensation, Place, PlacedFoci
from tactometry.stimuli.time_reversal.stimulus.sensation import FocusReading

KERNELS = {
    "plate.rectangle", "plate.dispersion.frequencies_rad_per_s", "plate.modal_sum", "plate.propagator",
    "plate.oscillators", "plate.ritz", "focusing.modulator", "focusing.bursts",
}  # fmt: skip
"""Numerical kernels: their arguments are arrays that the public functions make."""
RESULTS = {
    "Decay", "Guide", "LossRow", "ContactCourse", "ContactCourses", "Receptances", "FocusLoss", "Findings",
    "RitzModes", "SeparableModes",
}  # fmt: skip
"""Classes that functions return and nobody else makes."""
OF_THE_PACKAGE = (("lift_off.one_sided_contacts", "still_m_per_n"), ("responses.measured.decay_of", "kept"))
"""Optional arguments that only the package passes."""
PLACES = {"index": Place(0.10), "middle": Place(0.13)}
AT = (0.1, 0.1)
LOADS = [PlateLoad(*AT, 9.0)]
INSTANCES = (
    Attenuation(3e-3, 0.1), ROOM, Contactor("rigid"), Fingertip(10.0), Tissue(), PulpLoad(*AT, 6e-3),
    Transducers(8), Target(contrast=3.0), DESIGN, EMISSION, TRAIN,
    TimeReversalStimulus(FOCUS, reversal_s=0.1, heard=FOCUS, path=[0], tau_s=0.1),
    Glass("x", 64e9, 0.2, 2230.0, "here"), Excitation(CLICK, 2e3, 0.0, 1e3, "click"), LOADS[0],
    SprungMass(*AT, 1e-3, 1e5), Rectangular(), RaisedCosine(), Exponential(), Sinc(), Table((0.0, 1.0)),
    Pattern(10.0, 0.2), PLATE, Analogue(), OneBit(), SigmaDelta(), PulseWidth(200.0), RESPONSES, SCREEN, GlassPanel(),
    TimeReversalSensation(SETUP), FocusReading(SETUP), SETUP, BAND, Butterworth(500.0), SHEETS[0],
    NoiseSpectrum(np.array([10.0, 20.0]), np.array([1e-9, 1e-9])), PointForce(*AT), Patch(*AT, 0.01, 0.01),
    DiscPatch(*AT, 0.01), RECEPTANCES, FocusLoss(S, 0.1 * S, 0.1 * S), MODAL, FREE, Place(*AT),
    PlacedFoci(SETUP, f_max_hz=900.0, places=PLACES, place="index + middle"),
    FingersSensation(SETUP, PLACES, ("index",)), NamedGlass("soda-lime"),
)  # fmt: skip
ARGUMENTS: dict[str, Any] = {
    "alpha": 1.25, "among": np.ones((2, 1, 1), complex), "amplitude_m": 1e-5, "amplitudes_m": BUMP, "apart": 2,
    "area_m2": 1e-4, "at": WEIGHTS, "at_m": AT, "back": BUMP, "band": BAND, "boundary": "SSSS",
    "channel_capacitance_f": 1e-9, "channels": [1], "contact": Contact(2.0), "contact_m": 0.01,
    "contactors": [Contactor("finger")], "contributions": FIELD, "cutoff_hz": 100.0, "delay_s": [1e-3, 2e-3],
    "design": DESIGN, "displacement_m": BUMP, "distance_m": 0.3, "duration_s": 0.1, "emission": EMISSION,
    "energy": np.exp(-np.arange(32.0) / 5), "f_max_hz": 1e3, "f_mean_hz": [1e3], "f_min_hz": 100.0, "field_m": FIELD,
    "finger": Fingertip(), "fingers": ("index",), "flank_hz": 50.0, "foci": RESPONSES, "focus": AT, "force_n": 2.0,
    "forces_n": [2.0], "free_m": BUMP[None], "frequency_hz": [1e3], "full_scale": 1.0, "gain": Butterworth(500.0),
    "glass": "soda-lime", "grid_m": (LINE, LINE), "heard": SETUP.responses_at(*AT), "height": 1.0, "index": 1,
    "inset_m": 0.012, "kelvin": 5.0, "learnt": RESPONSES, "length_m": 0.2, "level": 0.5, "loads": LOADS,
    "loss_tangent": 0.017, "mass_kg": 0.15, "modes": MODAL, "modulation": "burst", "modulus_pa": 1e9,
    "moment_n_per_v": 1e-3, "n_channels": np.array([8.0]), "n_draws": 2, "n_reversal": 9, "n_samples": 9,
    "n_transducers": 4, "n_x": 3, "n_y": 4, "name": "x", "of": WEIGHTS, "order": 4,
    "oscillators": SCREEN.oscillators(1e3), "path": [0, 1], "on_x": lambda axis: axis.value(0.1),
    "on_y": lambda axis: axis.value(0.1), "pattern": Pattern(10.0, 0.2), "peaks_m": [1e-5, 2e-5], "place": "index",
    "places": PLACES, "plate": PLATE, "per_channel": True, "played": CLICK, "point": 1, "points": POINTS,
    "profile": BUMP, "position": np.array([0.0, 0.5]), "provenance": {"who": "me"}, "pulp_mass_kg": 1e-4,
    "quantiser": OneBit(), "quantity": "displacement", "radius_m": 6e-3, "rate_hz": 2e3, "recorded": CLICK,
    "regularisation": 1e-6, "relative_permittivity": 1800.0, "relearn": False, "repetition_s": 3e-3,
    "response": DECAYING[0, 0], "responses": RESPONSES, "reversal_s": 0.1, "rng": np.random.default_rng(0),
    "room": ROOM, "rows": [0, 1, 0], "s": S, "sample": 7, "samples": [3, 7], "screen": SCREEN, "setup": SETUP,
    "shear_factor": 0.8, "shift_per_k": -5e-5, "side_m": 1e-2, "signal": SIGNAL, "signal_m": DECAYING[0, 0], "size": 4,
    "snr_db": 20.0, "sound_speed_m_per_s": 343.0, "sources": SCREEN.sources, "start_s": 0.01, "static_to_hz": 2e3,
    "stiffness": S[:, None], "subsets": {"all": [0, 1]}, "target": Target(1e-2, 5.0, 1e-6, 200.0), "tau_s": 3e-3,
    "there": LINE, "thickness_m": 1e-3, "thicknesses_m": [1e-3], "times_s": [0.0, 0.01], "tissue": Tissue(),
    "to": WEIGHTS, "to_contacts": np.ones((1, 1, 2), complex), "train": TRAIN, "transducers": Transducers(8),
    "voltage_v": 30.0, "wanted_resolution_m": 1e-2, "waveform": FIELD, "wavenumber_rad_per_m": [100.0], "weight": 0.5,
    "weights": [1.0, -1.0], "where": "fingers", "width_m": 0.1, "window": np.ones(400), "x": BUMP, "x_m": [0.1],
    "y_m": [0.1],
}  # fmt: skip
AT_SETUPS_RATE = (
    "contact_force_n", "contact_forces_n", "FocusReading.sensation_db", "FocusReading.contact_force_n",
    "free_displacement", "displacement_at_focus_m",
)  # fmt: skip
OF_ONE_CALL: dict[str, Any] = {
    **{f"{name}.signal": AT_SETUP for name in AT_SETUPS_RATE}, "amplitudes_m.reversal_s": np.array([1e-3]),
    "contrast_over.reversal_s": np.array([1e-3]), "wavelength_to_patch.frequency_hz": 1e3,
    "ejection_force_n.frequency_hz": 1e4, "force_loss.places": {"F": AT}, "FocusLoss.by.stiffness": S,
    "focus_loss.contact": PulpLoad(*AT, 6e-3), "reversed_waveform.reversal_s": 0.2, "drive.reversal_s": 0.2,
    "envelope.signal": BUMP, "resolution_per_focus_m.foci": [(0.14, 0.1)], "one_sided_contact.free_m": BUMP,
    "one_sided_contacts.force_n": [1.0], "Plate.contains.x_m": 0.1, "Plate.contains.y_m": 0.1,
    "learn.recorded": DECAYING[0], "Responses.mean_of.points": [1], "PlacedFoci.at.level": -60.0,
    "TimeReversalStimulus.at.level": 1e-9, "TimeReversalStimulus.voltage_v.level": 1e-9, "FocusTrain.at.level": -60.0,
    "place_on.x_m": 0.1, "place_on.y_m": 0.1, "Setup.responses_at.x_m": 0.1, "Setup.responses_at.y_m": 0.1,
    "Setup.responses_at_each.places": (AT, (0.2, 0.1)), "PlacedFoci.heard.learnt": None, "field.at_m": GRID,
    "movie.at_m": GRID, "width_m.at_m": LINE, "best_sheet.among": SHEETS, "contrast_whole_of.amplitude_m": 4.0,
    "SeparableModes.field.amplitude": np.ones(len(MODAL.frequency_hz)),
    "RitzModes.field.amplitude": np.ones(len(FREE.frequency_hz)),
}  # fmt: skip


def public() -> Iterator[tuple[str, Any]]:
    """Yield the public functions and dataclasses by their names below the package."""
    for info in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        inner = info.name.removeprefix(f"{package.__name__}.")
        if info.ispkg or inner in KERNELS or inner.startswith("figures"):
            continue
        module = importlib.import_module(info.name)
        for name, thing in vars(module).items():
            is_own = not name.startswith("_") and getattr(thing, "__module__", None) == module.__name__
            is_class = is_dataclass(thing) and isinstance(thing, type)
            if is_own and (isfunction(thing) or is_class) and f"{inner}.{name}" not in KERNELS:
                yield f"{inner}.{name}", thing


def calls(folder: Path) -> dict[str, Call]:
    """Return a valid call of each public callable by its dotted name."""
    npz, toml = written(folder)
    own = OF_ONE_CALL | {
        "read_plate.path": toml, "read_provenance.path": npz, "read.paths": [npz],
        "write_learnt.path": folder / "learnt.npz",
    }  # fmt: skip
    instances = {type(each): each for each in INSTANCES}
    found = {}
    for name, thing in public():
        short = name.rpartition(".")[2]
        if isfunction(thing):
            found[name] = call_of(thing, short, ARGUMENTS, own)
            continue
        if short not in RESULTS:
            found[name] = Call(thing, valid_arguments(instances[thing]))
        for method in methods(thing):
            found[f"{name}.{method}"] = call_of(getattr(instances[thing], method), f"{short}.{method}", ARGUMENTS, own)
    for name, argument in OF_THE_PACKAGE:
        del found[name].arguments[argument]
    return found
