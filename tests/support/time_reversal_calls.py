"""Valid arguments of every public function of time reversal."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
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
    LOW,
    MODAL,
    PLATE,
    POINTS,
    RECEPTANCES,
    RESPONSES,
    ROOM,
    SAMPLING,
    SCREEN,
    SETUP,
    SHEETS,
    SIGNAL,
    TRAIN,
    WEIGHTS,
    S,
    written,
)

from tactometry.contact import Contact
from tactometry.stimuli.composition.effect import Demand
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal
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
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue
from tactometry.stimuli.time_reversal.responses.learning import Excitation
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, SprungMass
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.glass_panel import GlassPanel
from tactometry.stimuli.time_reversal.screen.transducer import Patch, PointForce
from tactometry.stimuli.time_reversal.stimulus.placed_foci import Place, PlacedFoci
from tactometry.stimuli.time_reversal.stimulus.sensation import FocusReading

PLACES = {"index": Place(0.10), "middle": Place(0.13)}
AT_PLACES = PlacedFoci(SETUP, f_max_hz=900.0, places=PLACES, place="index + middle")


def calls(folder: Path) -> Mapping[str, Mapping[str, Any]]:
    """Valid arguments of every public function, by module; `self` is the instance of a method."""
    npz, toml = written(folder)
    on_plate = {"plate": PLATE, "frequency_hz": 1e3}
    heard = {"responses": RESPONSES}
    driven = {"screen": SCREEN, "signal": SIGNAL, **LOW}
    return {
        "screen.attenuation": {
            "Attenuation.rate_per_s": {"self": Attenuation(3e-3), "frequency_hz": [1e3]},
        },
        "design.closed_forms": {
            **{
            name: {"plate": PLATE, "side_m": 1e-2, "band": BAND}
            for name in ("patch_response", "passed_hz", "effective_hz", "weighted_width_m")
        },
            "one_bit_amplitude_ratio": {"reversal_s": [6e-3], "tau_s": 3e-3},
            "analogue_amplitude_ratio": {"reversal_s": [6e-3], "tau_s": 3e-3},
            "contrast_whole": {"room": ROOM},
            "contrast_limit": {"room": ROOM},
            "repetition_noise_ratio": {"repetition_s": [5e-3], "tau_s": 3e-3},
            "repetition_amplitude_ratio": {"reversal_s": 6e-3, "repetition_s": 3e-3, "tau_s": 3e-3},
            "focus_profile": {"plate": PLATE, "band": BAND, "radius_m": [0.0, 0.1]},
            "resolution_m": {"plate": PLATE, "band": BAND, "level": 0.5},
            "half_wavelength_m": {"plate": PLATE, "f_mean_hz": [1e3], "alpha": 1.25},
        },
        "fingertip": {
            "Fingertip.load": {"self": Fingertip(), "at_m": (0.1, 0.1), "force_n": 2.0},
            "Fingertip.contact": {"self": Fingertip(impedance="tissue"), "at_m": (0.1, 0.1), "force_n": 2.0},
        },
        "pulp": {
            "Tissue.shear_pa": {"self": Tissue(), "s": S},
            "PulpLoad.weights": {"self": PulpLoad(0.1, 0.1, 6e-3), "screen": SCREEN, **LOW},
            "PulpLoad.modal_force": {"self": PulpLoad(0.1, 0.1, 6e-3), "modes": SCREEN.modes(1e3)},
            "PulpLoad.check": {"self": PulpLoad(0.1, 0.1, 6e-3), "plate": PLATE, "name": "x"},
            "PulpLoad.spread": {"self": PulpLoad(0.1, 0.1, 6e-3), "s": S, "plate": PLATE},
            "PulpLoad.dynamic_stiffness": {"self": PulpLoad(0.1, 0.1, 6e-3), "s": S},
            "disc_stiffness": {"s": S, "radius_m": 6e-3, "tissue": Tissue()},
        },
        "focus_loss": {
            "FocusLoss.by": {"self": FocusLoss(S, 0.1 * S, 0.1 * S), "stiffness": S},
            "focus_loss": {
                "screen": SCREEN, "focus": (0.1, 0.1), "contact": PulpLoad(0.1, 0.1, 6e-3), "emission": EMISSION
            },
        },
        "finger": {
            "force_loss": {
                "screen": SCREEN, "focus": (0.1, 0.1), "places": {"F": (0.1, 0.1)},
                "contactors": [Contactor("finger")], "forces_n": [2.0], "emission": EMISSION,
            },
            "amplitude_loss": {
                "screen": SCREEN, "focus": (0.1, 0.1), "loads": [PlateLoad(0.2, 0.1, 9.0)], "emission": EMISSION,
                "relearn": False,
            },
            "ejection_force_n": {"amplitude_m": 1e-5, "frequency_hz": 1e4, "pulp_mass_kg": 1e-4},
            "Contactor.loads": {"self": Contactor("rigid"), "plate": PLATE, "at_m": (0.1, 0.1), "force_n": 2.0},
            "hertz_stiffness_n_per_m": {"force_n": 1.0, "radius_m": 1e-3, "modulus_pa": 1e9},
        },
        "lift_off": {
            "one_sided_contacts": {
                "screen": SCREEN, "free_m": BUMP[None], "loads": [PlateLoad(0.1, 0.1, 9.0)], "force_n": [1.0],
                "rate_hz": 1e4, "f_max_hz": 1e3,
            },
            "one_sided_contact": {
                "screen": SCREEN, "at_m": (0.1, 0.1), "free_m": BUMP, "rate_hz": 1e4, "force_n": 2.0,
                "finger": Fingertip(), **LOW,
            },
        },
        "responses.plate_constants": {
            "schroeder_db": {"response": CLICK},
            "tau_s": {"response": DECAYING[0, 0], "rate_hz": 2e3},
            "decay_of": {"energy": np.exp(-np.arange(32.0) / 5)},
        },
        "design.guide": {
            "recommend": {
                "plate": PLATE, "transducers": Transducers(8), "band": DESIGN.band, "tau_s": 3e-3,
                "target": Target(1e-2, 5.0, 1e-6, 200.0),
            },
            "amplitudes_m": {"design": DESIGN, "reversal_s": np.array([1e-3])},
            "contrast_over": {"design": DESIGN, "n_channels": np.array([8.0]), "reversal_s": np.array([1e-3])},
            "n_held": {"plate": PLATE, "side_m": 1e-2},
            "thickness_for_m": {"plate": PLATE, "band": BAND, "wanted_resolution_m": 1e-2},
            "wavelength_to_patch": {**on_plate, "side_m": 1e-2},
        },
        "plate.dispersion": {
            "wavenumber_rad_per_m": on_plate,
            "wavelength_m": on_plate,
            "phase_velocity_m_per_s": on_plate,
            "group_velocity_m_per_s": on_plate,
            "mindlin_angular_frequency_rad_per_s": {
                "plate": PLATE, "wavenumber_rad_per_m": [100.0], "shear_factor": 0.8,
            },
            "mindlin_wavenumber_rad_per_m": {**on_plate, "shear_factor": 0.8},
            "shear_stiffness_n_per_m": {"plate": PLATE, "shear_factor": 0.8},
        },

        "stimulus.focus_train": {
            **{
            f"TimeReversalStimulus.{name}": {"self": TimeReversalStimulus(FOCUS), "level": 1e-9}
            for name in ("at", "voltage_v")
        },
            "FocusTrain.heard": {"self": TRAIN, "learnt": RESPONSES},
            "FocusTrain.at": {"self": TRAIN, "level": -60.0},
            "FocusTrain.voltage_v": {"self": TRAIN, "level": -60.0},
            "measured": {"train": TRAIN, "heard": SETUP.responses_at(0.1, 0.1)},
        },
        "focusing.focusing": {
            "Emission.responses": {
                "self": EMISSION, "screen": SCREEN, "points": POINTS, "loads": [PlateLoad(0.1, 0.1, 9.0)],
            },
            "Emission.drive": {"self": EMISSION, "foci": RESPONSES},
            "reversed_waveform": {
                "foci": RESPONSES, "reversal_s": 0.2, "weights": [1.0, -1.0], "window": np.ones(400),
            },
            "drive": {
                "foci": RESPONSES, "voltage_v": 30.0, "quantiser": OneBit(), "reversal_s": 0.2,
                "weights": [1.0, -1.0], "window": np.ones(400),
            },
            "emitted": {"signal": SIGNAL, **heard},
            "focus_amplitudes": {"signal": SIGNAL, **heard},
            "focus_amplitude": {"signal": SIGNAL, **heard, "point": 1},
        },
        "plate.glass": {
            "read_plate": {"path": toml},
            "NamedGlass": {"glass": "soda-lime"},
            "Glass.plate": {
                "self": Glass("x", 64e9, 0.2, 2230.0, "here"), "length_m": 0.2, "width_m": 0.1, "thickness_m": 1e-3,
                "boundary": "SSSS",
            }
        },
        "responses.learning": {
            "sweep": {"f_min_hz": 100.0, "f_max_hz": 900.0, "rate_hz": 2e3, "duration_s": 0.1},
            "sequence": {"order": 4, "rate_hz": 2e3},
            "deconvolve": {"played": CLICK, "recorded": CLICK, "n_samples": 9, "regularisation": 1e-6},
            "delay_s": {"played": CLICK, "recorded": CLICK, "rate_hz": 2e3},
            "learn": {
                "played": CLICK, "recorded": DECAYING[0], "rate_hz": 2e3, "duration_s": 0.1,
                "quantity": "velocity", "regularisation": 1e-6,
            },
            "as_displacement": {**heard, "f_min_hz": 100.0, "f_max_hz": 900.0},
            "write_learnt": {**heard, "path": folder / "learnt.npz", "provenance": {"who": "me"}},
            "read_provenance": {"path": npz},
        },
        "responses.load": {
            "PlateLoad.weights": {"self": PlateLoad(0.1, 0.1), "screen": SCREEN, **LOW},
            "PlateLoad.spread": {"self": PlateLoad(0.1, 0.1), "s": S, "plate": PLATE},
            "SprungMass.spread": {"self": SprungMass(0.1, 0.1, 1e-3, 1e5), "s": S, "plate": PLATE},
            "PlateLoad.dynamic_stiffness": {"self": PlateLoad(0.1, 0.1, 9.0), "s": S},
            "SprungMass.weights": {"self": SprungMass(0.1, 0.1, 1e-3, 1e5), "screen": SCREEN, **LOW},
            "SprungMass.dynamic_stiffness": {"self": SprungMass(0.1, 0.1, 1e-3, 1e5), "s": S},
            "Receptances.of": {"oscillators": SCREEN.oscillators(1e3), "mass_kg": 0.15, "s": S},
            "Receptances.between": {"self": RECEPTANCES, "to": WEIGHTS, "of": WEIGHTS},
            "Receptances.correction": {
                "self": RECEPTANCES, "to": WEIGHTS, "of": WEIGHTS, "at": WEIGHTS, "stiffness": S[:, None],
            },
            "Receptances.among": {"self": RECEPTANCES, "at": WEIGHTS},
            "contact_transfer": {
                "to_contacts": np.ones((1, 1, 2), complex), "among": np.ones((2, 1, 1), complex),
                "stiffness": S[:, None],
            },
            "loaded_responses": {"screen": SCREEN, "points": POINTS, "loads": [PlateLoad(0.1, 0.1, 9.0)], **SAMPLING},
            "contour": {"n_samples": 9, "rate_hz": 2e3},
        },
        "responses.measured": {
            "read": {"paths": [npz], "full_scale": 1.0, "quantity": "velocity"},
            "trimmed": {**heard, "start_s": 0.01, "duration_s": 0.1},
            "aligned": {**heard, "delay_s": [1e-3, 2e-3]},
            "inspect": {**heard, "snr_db": 20.0},
            "reciprocity_error": {"there": LINE, "back": BUMP},
        },
        "focusing.merit": {
            "modal_amplitudes": {**driven, "sample": 7, "quantity": "velocity"},
            "grid": {"screen": SCREEN, "n_x": 3, "n_y": 4},
            "field": {**driven, "sample": 7, "at_m": GRID},
            "movie": {**driven, "samples": [3, 7], "at_m": GRID},
            "modal_history": {**driven, "samples": [3, 7]},
            "contributions_m": {**heard, "voltage_v": 30.0},
            "amplitude_over_count_m": {"contributions": FIELD, "rng": np.random.default_rng(0), "n_draws": 2},
            "amplitude_by_subset_m": {"contributions": FIELD, "subsets": {"all": [0, 1]}},
            "resolution_per_focus_m": {"screen": SCREEN, "foci": [(0.14, 0.1)], "emission": EMISSION, "level": 0.5},
            "switched_power_w": {"signal": SIGNAL, "channel_capacitance_f": 1e-9},
            "dielectric_power_w": {"signal": SIGNAL, "channel_capacitance_f": 1e-9, "loss_tangent": 0.017},
            "contrast_whole_of": {"amplitude_m": 4.0, "field_m": FIELD},
            "width_m": {"at_m": LINE, "profile": BUMP, "level": 0.5},
            "area_m2": {"field_m": FIELD, "grid_m": (LINE, LINE), "level": 0.5},
            "envelope": {"signal": BUMP},
            "temporal_width_s": {"signal_m": DECAYING[0, 0], "rate_hz": 2e3, "level": 0.5},
            "uniformity": {"amplitudes_m": BUMP},
        },
        "plate.modes": {
            "values": {"modes": MODAL, "x_m": [0.1], "y_m": [0.1]},
            "laplacians": {"modes": MODAL, "x_m": [0.1], "y_m": [0.1]},
            "modes_of": {"plate": PLATE, "f_max_hz": 1e3, "shear_factor": 0.8},
            **{
                f"{kind}Modes.{name}": {"self": modes, **arguments}
                for kind, modes in (("Separable", MODAL), ("Ritz", FREE))
                for name, arguments in {
                    "products": {"on_x": lambda axis: axis.value(0.1), "on_y": lambda axis: axis.value(0.1)},
                    "field": {"amplitude": np.ones(len(modes.frequency_hz)), "x_m": GRID[0], "y_m": GRID[1]},
                    "frame": {"x_m": GRID[0], "y_m": GRID[1]},
                }.items()
            },
        },
        "focusing.pattern": {
            **{
                f"{type(envelope).__name__}.at": {"self": envelope, "position": np.array([0.0, 0.5])}
                for envelope in (Rectangular(), RaisedCosine(), Exponential(), Sinc(), Table((0.0, 1.0)))
            },
            "pattern_drive": {
                "foci": RESPONSES, "pattern": Pattern(10.0, 0.2), "voltage_v": 30.0, "quantiser": OneBit(),
                "reversal_s": 0.1, "path": [0, 1], "modulation": "burst", "tau_s": 3e-2,
            },
            "reversed_waveforms": {"foci": RESPONSES, "rows": [0, 1, 0], "reversal_s": 0.1},
            "focus_samples": {"pattern": Pattern(10.0, 0.2), "rate_hz": 2e3, "n_reversal": 9},
            "focus_starts": {"pattern": Pattern(10.0, 0.2), "rate_hz": 2e3},
            "burst_s": {"weight": 0.5, "reversal_s": 7e-3, "tau_s": 3.5e-3},
        },
        "plate.plate": {
            "Plate.contains": {"self": PLATE, "x_m": 0.1, "y_m": 0.1},
            "Plate.check_holds": {"self": PLATE, "name": "at_m", "at_m": (0.1, 0.1)},
            "Plate.frequencies_hz": {"self": PLATE, **LOW},
            "navier": {"plate": PLATE, **LOW},
            "ritz": {"plate": PLATE, **LOW},
            "ritz_frequencies_hz": {"plate": PLATE, **LOW},
            "degrees": {"plate": PLATE, **LOW},
            "degrees_called_for": {"plate": PLATE, **LOW},
        },
        "focusing.quantiser": {
            "Analogue.quantise": {"self": Analogue(), "waveform": FIELD, "rate_hz": 2e3},
            "normalised": {"waveform": FIELD, "per_channel": True},
            "one_bit": {},
        },
        "focusing.one_bit": {"OneBit.quantise": {"self": OneBit(), "waveform": FIELD, "rate_hz": 2e3}},
        "focusing.sigma_delta": {"SigmaDelta.quantise": {"self": SigmaDelta(), "waveform": FIELD, "rate_hz": 2e3}},
        "focusing.pulse_width": {
            "PulseWidth.quantise": {"self": PulseWidth(200.0), "waveform": FIELD, "rate_hz": 2e3},
            "PulseWidth.size": {"self": PulseWidth(200.0), "demand": Demand(TimeReversal(), (), (), (), 0.1)},
        },
        "responses.responses": {
            "through": {**heard, "gain": Butterworth(500.0)},
            "band_limited": {**heard, "band": BAND},
            "inaudible": {**heard, "cutoff_hz": 100.0, "flank_hz": 50.0},
            "Responses.at_point": {"self": RESPONSES, "index": 1},
            "Responses.mean_of": {"self": RESPONSES, "points": [1]},
            "Responses.of_channels": {"self": RESPONSES, "channels": [1]},
            "impulse_responses": {
                "screen": SCREEN, "points": POINTS, **SAMPLING, "quantity": "displacement", "static_to_hz": 2e3,
            },
            "samples_in": {"name": "duration_s", "duration_s": 1.0, "rate_hz": 2e3},
            "chunks": {"n_samples": 9, "size": 4},
            "values_at": {"screen": SCREEN, "points": POINTS, **LOW},
        },
        "screen.screen": {
            **{
            f"Screen.{name}": {"self": SCREEN, **LOW} for name in ("modes", "oscillators", "modal_forces")
        },
            "warmed": {"screen": SCREEN, "kelvin": 5.0, "shift_per_k": -5e-5},
        },
        "stimulus.placed_foci": {
            "PlacedFoci": {"setup": SETUP, "places": PLACES, "place": "index", "f_max_hz": 900.0},
            "PlacedFoci.heard": {"self": AT_PLACES, "learnt": None},
            "Place": {"x_m": 0.1, "y_m": 0.1},
            "Place.on": {"self": Place(0.1), "setup": SETUP},
            "FingersSensation": {"setup": SETUP, "places": PLACES, "fingers": ("index",), "reference_m": 1e-5},
            "check_fingers": {"where": "fingers", "setup": SETUP, "places": PLACES, "fingers": ("index",)},
        },
        "stimulus.contact_force": {
            **{
                name: {"setup": SETUP, "signal": AT_SETUP, "loads": [PlateLoad(0.1, 0.1, 9.0)]}
                for name in ("contact_force_n", "contact_forces_n")
            },
        },
        "stimulus.sensation": {
            **{
                f"FocusReading.{name}": {"self": FocusReading(SETUP), "signal": AT_SETUP, "contact": Contact(2.0)}
                for name in ("sensation_db", "contact_force_n")
            },
            "displacement_at_focus_m": {"setup": SETUP, "signal": AT_SETUP, "loads": [PlateLoad(0.1, 0.1, 9.0)]},
            "free_displacement": {"signal": AT_SETUP, "setup": SETUP, "at_m": (0.1, 0.1)},
            "place_on": {"setup": SETUP, "x_m": 0.1, "y_m": 0.1},
            "loaded_displacements": {"free_m": BUMP[None], "setup": SETUP, "loads": [PlateLoad(0.1, 0.1, 9.0)]},
            "peaks": {"x": BUMP, "height": 1.0, "apart": 2},
            "events": {"displacement_m": BUMP, "rate_hz": 1e3},
            "felt_amplitude_m": {"times_s": [0.0, 0.01], "peaks_m": [1e-5, 2e-5]},
        },
        "stimulus.setup": {
            "Setup.responses_at": {"self": SETUP, "x_m": 0.1, "y_m": 0.1}, "Setup.learnt": {"self": SETUP},
            "Setup.responses_at_each": {"self": SETUP, "places": ((0.1, 0.1), (0.2, 0.1))},
        },
        "focusing.sound": {
            "a_weighting_db": {"frequency_hz": [1e3]},
            "coincidence_frequency_hz": {"plate": PLATE, "sound_speed_m_per_s": 343.0},
            "radiation_efficiency": on_plate,
            "noise": {**driven, "distance_m": 0.3, "duration_s": 0.1},
            "velocity_spectrum": driven,
        },
        "filters": {
            "filtered": {"samples": FIELD, "rate_hz": 2e3, "gain": Butterworth(500.0)},
            **{
                f"{type(gain).__name__}.at": {"self": gain, "frequency_hz": np.array([0.0, 50.0])}
                for gain in (BAND, Butterworth(500.0))
            },
        },
        "plate.statics": {
            "deflection_m": {"plate": PLATE, "force_n": 2.0, "at_m": (0.1, 0.1), "x_m": [0.1], "y_m": [0.1]},
            "bending_stress_pa": {"plate": PLATE, "force_n": 2.0, "contact_m": 0.01},
        },

        "design.thickness": {
            "sheets": {
                "plate": PLATE, "transducers": Transducers(8), "band": DESIGN.band, "tau_s": 3e-3, "target": Target(),
                "thicknesses_m": [1e-3],
            },
            "best_sheet": {"among": SHEETS, "thickness_m": 1e-3},
        },
        "screen.transducer": {
            "capacitance_f": {"area_m2": 1e-4, "thickness_m": 3e-4, "relative_permittivity": 1800.0},
            **{
                f"{type(source).__name__}.{name}": {"self": source, **arguments}
                for source in (PointForce(0.1, 0.1), Patch(0.1, 0.1, 0.01, 0.01), DiscPatch(0.1, 0.1, 0.01))
                for name, arguments in {
                    "modal_force": {"modes": MODAL},
                    "check": {"plate": PLATE, "name": "source"},
                }.items()
            },
            "modal_forces": {"modes": MODAL, "sources": SCREEN.sources},
            "border": {"plate": PLATE, "n_transducers": 4, "side_m": 0.01, "inset_m": 0.012, "moment_n_per_v": 1e-3},
        },
    }  # fmt: skip


def constructors() -> Iterator[tuple[str, object]]:
    """Sound instances, whose fields are the arguments of their classes."""
    yield from {
        "screen.attenuation": Attenuation(3e-3, 0.1),
        "design.closed_forms": ROOM, "finger": (Contactor("soft"),), "fingertip": (Fingertip(10.0),),
        "pulp": (Tissue(), PulpLoad(0.1, 0.1, 6e-3)),
        "design.guide": (Transducers(8), Target(contrast=3.0), DESIGN),
        "focusing.focusing": EMISSION,
        "stimulus.focus_train": (
            TRAIN, TimeReversalStimulus(FOCUS, reversal_s=0.1, heard=FOCUS, path=[0], tau_s=0.1),
        ),
        "plate.glass": Glass("x", 64e9, 0.2, 2230.0, "here"),
        "responses.learning": Excitation(CLICK, 2e3, 0.0, 1e3, "click"),
        "responses.load": (PlateLoad(0.1, 0.1, 10.0), SprungMass(0.1, 0.1, 1e-3, 1e5)),
        "focusing.pattern": (
            Rectangular(), RaisedCosine(), Exponential(), Sinc(), Table((0.0, 1.0)), Pattern(200.0, 0.05),
        ),
        "plate.plate": PLATE, "focusing.quantiser": Analogue(),
        "focusing.one_bit": OneBit(),
        "focusing.sigma_delta": SigmaDelta(), "focusing.pulse_width": PulseWidth(200.0),
        "responses.responses": RESPONSES, "screen.screen": SCREEN,
        "screen.glass_panel": GlassPanel(),
        "stimulus.sensation": (TimeReversalSensation(SETUP), FocusReading(SETUP)), "stimulus.setup": SETUP,
        "focusing.sound": NoiseSpectrum(np.array([10.0, 20.0]), np.array([1e-9, 1e-9])),
        "filters": (BAND, Butterworth(500.0)),
        "design.thickness": SHEETS[0],
        "screen.transducer": (PointForce(0.1, 0.1), Patch(0.1, 0.1, 0.01, 0.01), DiscPatch(0.1, 0.1, 0.01)),
    }.items()  # fmt: skip
