"""Refusals of arguments outside of their domains, each in one sentence."""

import math
from dataclasses import replace

import numpy as np
import pytest
from felt_models import felt_by

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal import Plate, Setup, TimeReversalSensation
from tactometry.stimuli.time_reversal.design.closed_forms import resolution_m
from tactometry.stimuli.time_reversal.design.guide import Design, Target, Transducers, n_held, recommend
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import Contactor
from tactometry.stimuli.time_reversal.fingertip import Fingertip
from tactometry.stimuli.time_reversal.focusing.focusing import Emission, drive, focus_amplitude
from tactometry.stimuli.time_reversal.focusing.merit import (
    area_m2,
    contrast_whole_of,
    dielectric_power_w,
    switched_power_w,
    uniformity,
    width_m,
)
from tactometry.stimuli.time_reversal.focusing.modulator import modulate
from tactometry.stimuli.time_reversal.focusing.pattern import PATTERNS, Pattern, Table, burst_s, pattern_drive
from tactometry.stimuli.time_reversal.focusing.pulse_width import PulseWidth
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import noise
from tactometry.stimuli.time_reversal.lift_off import one_sided_contact
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue, disc_stiffness
from tactometry.stimuli.time_reversal.responses.learning import deconvolve, learn, sequence, sweep
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, loaded_responses
from tactometry.stimuli.time_reversal.responses.measured import aligned, read, tau_s, trimmed
from tactometry.stimuli.time_reversal.responses.responses import Responses, band_limited, impulse_responses, samples_in
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import A4_PROTOTYPE, Screen
from tactometry.stimuli.time_reversal.screen.transducer import Patch, border
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain, TimeReversalStimulus
from tactometry.stimuli.time_reversal.stimulus.placed_foci import FingersSensation, Place, PlacedFoci
from tactometry.stimuli.time_reversal.stimulus.sensation import FocusReading

FREE = replace(A4_SCREEN, boundary="FFFF")
LOSS = Attenuation(3e-3)
SCREEN = Screen(A4_SCREEN, border(A4_SCREEN, 4), LOSS)
LOSSLESS = replace(SCREEN, attenuation=Attenuation(math.inf))
SAMPLING = {"rate_hz": 50e3, "duration_s": 4e-3, "f_max_hz": 5e3}
HEARD = Responses(np.random.default_rng(0).standard_normal((2, 3, 40)), 1e3)
ONE = Responses(np.ones((1, 2, 100)), 1e3)
SIGNAL, SHORT = Signal(np.ones((4, 9)), 1e4, "V"), Signal(np.ones((1, 1)), 1e3, "V")
LINE, BUMP = np.arange(5.0), np.array([0.0, 1.0, 4.0, 1.0, 0.0])
FIELD = np.outer(BUMP, BUMP)
SETUP = Setup(n_transducers=8, modes_to_hz=22e3, rate_hz=50e3)
FELT, TOUCH = felt_by(TimeReversalSensation(SETUP)), Contact(1.0)
PLACES = {"index": Place(0.10), "middle": Place(0.12), "near": Place(0.105)}
AT_TIP = (0.1, 0.1)


def plate(poisson_ratio=0.2, boundary="SSSS", side_m=0.3):
    return Plate(side_m, side_m, 1e-3, 64e9, poisson_ratio, 2230.0, boundary)


def heard(points, **changes):
    return impulse_responses(SCREEN, points, **{**SAMPLING, **changes})


def train(**changes):
    return FocusTrain(SETUP, **{"f_max_hz": 20e3, "voltage_max_v": 2000.0, **changes})


def foci(**changes):
    return PlacedFoci(SETUP, **{"f_max_hz": 20e3, "places": PLACES, "place": "index", **changes})


def opened(finger):
    return one_sided_contact(SCREEN, AT_TIP, BUMP, 1e4, 1e3, 0.5, finger)


def recommended(*patches):
    return recommend(A4_SCREEN, Transducers(*patches), Band(20e3, 60e3), 3.5e-3, Target())


PLATES = [
    (lambda: plate(poisson_ratio=0.6), "Plate.poisson_ratio: found 0.6, expected a number from 0 to 0.5"),
    (lambda: plate(boundary="SSXS"), "Plate.boundary: found 'SSXS', expected four letters of S, C, F for the edges"),
    (lambda: plate(boundary="FFFF", side_m=10.0).frequencies_hz(1e6),
     "f_max_hz: found 1000000.0, which needs 9996 x 9996 functions, more than can be held; lower f_max_hz or use the"),
    (lambda: A4_SCREEN.frequencies_hz(1e9), "number of modes below f_max_hz: found 1.79615e+07, expected at most"),
    (lambda: deflection_m(FREE, 1.0, (0.1, 0.1), 0.1, 0.1),
     "Plate.boundary: found 'FFFF', expected edges that prevent rigid-body motion"),
    (lambda: deflection_m(A4_SCREEN, 1.0, (0.1, 0.1), 0.1, 9.0),
     "(x_m, y_m)[0]: found (0.1, 9.0) m, expected a point of the plate of 0.297 x 0.21 m"),
    (lambda: bending_stress_pa(A4_SCREEN, 1.0, 0.25),
     "bending_stress_pa.contact_m: found 0.25, expected a number from 0 to 0.21"),
    (lambda: Screen(A4_SCREEN, (), LOSS), "Screen.sources: found none, expected at least one"),
    (lambda: Screen(A4_SCREEN, (Patch(0.0, 0.1, 0.01, 0.01),), LOSS),
     "Screen.sources[0]: found a transducer of 0.01 x 0.01 m at (0.0, 0.1) m, expected one within the plate of 0.297"),
]  # fmt: skip
RESPONSES = [
    (lambda: heard([(0.4, 0.1)]), "points[0]: found (0.4, 0.1) m, expected a point of the plate of 0.297 x 0.21 m"),
    (lambda: heard([]), "points: found none, expected at least one"),
    (lambda: heard((0.1, 0.1)), "impulse_responses.points[0]: found 0.1, expected (a finite number, a finite number)"),
    (lambda: heard([(0.1, 0.1, 0.1)] * 2), "impulse_responses.points[0]: found (0.1, 0.1, 0.1), expected (a finite"),
    (lambda: heard([(0.1, 0.1)], f_max_hz=25.1e3),
     "f_max_hz: found 25100.0, above the Nyquist frequency 25000.0; raise rate_hz or lower f_max_hz"),
    (lambda: heard([(0.1, 0.1)], quantity="x"),
     "impulse_responses.quantity: found 'x', expected one of displacement, velocity, acceleration"),
    (lambda: heard([(0.1, 0.1)], static_to_hz=1e3),
     "static_to_hz: found 1000.0 for displacement, expected a frequency above f_max_hz = 5000.0 and displacement"),
    (lambda: heard([(0.1, 0.1)], static_to_hz=1e5, quantity="velocity"),
     "static_to_hz: found 100000.0 for velocity, expected a frequency above f_max_hz = 5000.0 and displacement"),
    (lambda: samples_in("duration_s", 1e9, 1e3),
     "duration_s: found 1000000000.0 s at 1000.0 Hz, expected at most 1e+09 samples"),
    (lambda: Responses(np.zeros((1, 0, 3)), 1e3),
     "Responses.samples: found shape (1, 0, 3), expected (n_points, n_channels, n_samples) with at least one point"),
    (lambda: Responses(np.zeros((1, 1, 3)), 1e3, "jerk"),
     "Responses.quantity: found 'jerk', expected one of displacement, velocity, acceleration"),
    (lambda: Band(5e3, 5e3), "Band: found 5000.0 to 5000.0 Hz, which is empty; expected f_min_hz below f_max_hz"),
    (lambda: band_limited(HEARD, Band(100.0, 600.0)),
     "Band.f_max_hz: found 600.0, above the Nyquist frequency 500.0 of the responses; lower it"),
    (lambda: trimmed(HEARD, 0.0, 1.0), "start_s, duration_s: found 0.0 and 1.0, expected a piece of 0.04 s"),
    (lambda: aligned(HEARD, [0.0]), "delay_s: found 1, expected 3, one per channel"),
    (lambda: read([]), "read.paths: found none, expected at least one"),
    (lambda: tau_s(np.zeros(100), 1e3), "response: found zero everywhere, expected an impulse response"),
    (lambda: tau_s(np.array([1.0, 0.9]), 1e3), "response: found 2 samples, expected at least 32"),
    (lambda: tau_s(np.ones(1000), 1e3), "response: found a fall by 0.0 dB before its end or noise floor, expected at"),
    (lambda: deconvolve(np.zeros(4), np.ones(8), 4), "played: found zeros alone, expected an excitation"),
    (lambda: deconvolve(np.ones(4), np.ones(8), 9), "deconvolve.n_samples: found 9, expected a number from 1 to 8"),
    (lambda: learn(np.ones((2, 4)), np.ones((3, 8)), 1e3, duration_s=0.004),
     "learn: found played (2, 4) and recorded (3, 8), expected (n_played,) or one row per channel, and (n_channels,"),
    (lambda: sweep(10.0, 600.0, rate_hz=1e3, duration_s=1.0),
     "sweep.f_max_hz: found 600.0, expected a number from 10 to 500"),
    (lambda: sequence(1, rate_hz=1e3), "sequence.order: found 1, expected a number from 2 to 24"),
]  # fmt: skip
FOCUSING = [
    (lambda: drive(HEARD, 30.0, reversal_s=0.1),
     "reversal_s: found 0.1, longer than the responses of 0.04 s; learn longer responses or shorten T"),
    (lambda: drive(HEARD, 30.0, reversal_s=-1.0), "reversal_s: found -1.0, expected a finite time, at least 0"),
    (lambda: drive(HEARD, 30.0, weights=[1.0]), "weights: found [1.0], expected 2 finite numbers, one per focus"),
    (lambda: drive(HEARD, 30.0, window=np.ones(3)), "window: found shape (3,), expected (40,)"),
    (lambda: drive(Responses(np.zeros((1, 2, 9)), 1e3), 30.0),
     "foci: found responses that are zero everywhere, expected a focus that some transducer can move (not on a"),
    (lambda: focus_amplitude(SIGNAL, HEARD), "signal: found 4 channels at 10000.0 Hz, expected 3 at 1000.0 Hz as in"),
    (lambda: Emission(Band(200.0, 9e3), 1e-5, 20e3),
     "Emission.reversal_s: found 1e-05, expected at least half a sample of 1 / 20000.0 s"),
    (lambda: Emission(Band(200.0, 11e3), 4e-3, 20e3),
     "Emission.band: found 11000.0 Hz, above the Nyquist frequency 10000.0; raise rate_hz or lower the band"),
    (lambda: SigmaDelta(order=3), "SigmaDelta.order: found 3, expected 1 or 2"),
    (lambda: PulseWidth(1e3, 1.5), "PulseWidth.scale: found 1.5, expected a number from 0 to 1"),
    (lambda: PulseWidth(3e5).quantise(np.ones((1, 4)), 1e6),
     "PulseWidth.carrier_hz: found 300000.0, expected at most a quarter of the rate, 250000.0 Hz; lower it or raise"),
    (lambda: modulate(np.array([[np.nan]]), 1), "modulate.signal[0, 0]: found nan, expected a finite number"),
    (lambda: width_m(LINE, np.ones(5)), "profile: found no point below 0.5 of the peak, expected a longer line"),
    (lambda: width_m(LINE, np.zeros(5)), "profile: found shape (5,), expected (5,), like at_m, and not all zero"),
    (lambda: width_m(LINE, BUMP[:3]), "profile: found shape (3,), expected (5,), like at_m, and not all zero"),
    (lambda: width_m(LINE[::-1], BUMP), "width_m.at_m: found shape (5,) not in ascending order, expected two or more"),
    (lambda: width_m(LINE, BUMP, 1.0), "width_m.level: found 1.0, expected a number above 0 and below 1"),
    (lambda: area_m2(np.zeros((5, 5)), (LINE, LINE)),
     "field_m: found shape (5, 5), expected (5, 5), like the grid, and not all zero"),
    (lambda: area_m2(FIELD, (LINE[:3], LINE)),
     "field_m: found shape (5, 5), expected (3, 5), like the grid, and not all zero"),
    (lambda: contrast_whole_of(1.0, np.zeros(4)), "field: found zero everywhere, expected a field that is not zero"),
    (lambda: uniformity(np.zeros(3)), "amplitudes_m: found 3 values, expected two or more, not all zero"),
    (lambda: noise(LOSSLESS, SIGNAL, 2e3), "Screen.attenuation.tau_s: found inf, expected a finite number above 0"),
    (lambda: switched_power_w(SHORT, 1e-9), "signal: found fewer than two samples, expected a drive"),
    (lambda: dielectric_power_w(SHORT, 1e-9), "signal: found fewer than two samples, expected a drive"),
    (lambda: Table((1.0,)), "Table.values: found (1.0,), expected at least two finite numbers"),
    (lambda: burst_s(2.0, 7e-3, 3e-3), "burst_s.weight: found 2.0, expected a number from 0 to 1"),
    (lambda: pattern_drive(HEARD, PATTERNS["P1"], 30.0, path=[0, 9]),
     "path: found [0, 9], expected 10 rows from 0 to 1, one per focus"),
    (lambda: pattern_drive(HEARD, PATTERNS["P1"], 30.0, modulation="burst"),
     "tau_s: found None, expected the attenuation constant for burst modulation"),
    (lambda: pattern_drive(HEARD, PATTERNS["P1"], 30.0, modulation="x"),
     "pattern_drive.modulation: found 'x', expected one of voltage, burst"),
]  # fmt: skip
STIMULI = [
    (lambda: TimeReversalStimulus(HEARD, level_unit="V"),
     "TimeReversalStimulus.level_unit: found 'V', expected one of m, dB re 1 um"),
    (lambda: TimeReversalStimulus(HEARD, heard=HEARD.at_point(0)),
     "TimeReversalStimulus.heard: found 1 points and 3 channels, expected 2 and 3 as in focus"),
    (lambda: TimeReversalStimulus(ONE, quantiser=Analogue(), supply_v=30.0),
     "TimeReversalStimulus.supply_v: found 30 with an analogue drive, expected drive ="),
    (lambda: TimeReversalStimulus(ONE, Pattern(20.0, 0.1), reversal_s=0.06, supply_v=30.0).at(1.0),
     "TimeReversalStimulus.reversal_s: found 0.06 s, expected at most the 0.05 s between foci, as supply_v makes one"),
    (lambda: FocusTrain(drive="analogue", supply_v=30.0), "FocusTrain.supply_v: found 30 with an analogue drive"),
    (lambda: train(f_max_hz=30e3), "FocusTrain.f_max_hz: found 30000.0, above the highest mode at 22000.0 Hz; lower"),
    (lambda: train(f_min_hz=25e3), "Band: found 25000.0 to 20000.0 Hz, which is empty; expected f_min_hz below"),
    (lambda: train(reversal_s=8e-3), "FocusTrain.reversal_s: found 0.008, longer than the responses of 0.007 s;"),
    (lambda: train(pattern="P7"), "FocusTrain.pattern: found 'P7', expected one of P0, P1, P2, P3, P4, P5, P6"),
    (lambda: train(pattern="P1", duration_s=0.04),
     "FocusTrain.duration_s: found 0.04, shorter than the 0.05 s of the drive; raise it"),
    (lambda: replace(SETUP, glass="ice"), "Setup.glass: found 'ice', expected one of Borofloat 33, DURAN borosilicate"),
    (lambda: replace(SETUP, boundary="SSS"), "Plate.boundary: found 'SSS', expected four letters of S, C, F for the"),
    (lambda: replace(SETUP, focus_x_m=0.3), "Setup.focus: found (0.3, 0.093) m, expected a point of the plate of"),
    (lambda: replace(SETUP, modes_to_hz=30e3),
     "Setup.modes_to_hz: found 30000.0, expected at most half of rate_hz, 25000.0; lower it or raise rate_hz"),
    (lambda: FELT.sensation_db(Signal(np.ones((2, 9)), 50e3, "V"), TOUCH),
     "signal: found 2 channels in 'V' at 50000 Hz, expected 8 in volt ('V') at 50000 Hz, as in the setup"),
    (lambda: FELT.sensation_db(Signal(np.ones((8, 9)), 50e3, "m"), TOUCH),
     "signal: found 8 channels in 'm' at 50000 Hz, expected 8 in volt ('V') at 50000 Hz, as in the setup"),
    (lambda: foci(place="ring"), "PlacedFoci.place: found 'ring', expected one of index, middle, near"),
    (lambda: foci(place="index+index"), "PlacedFoci.place[1]: found 'index' twice, expected each place once"),
    (lambda: foci(places={**PLACES, "far": Place(0.5)}),
     "PlacedFoci.places.far: found (0.5, 0.093) m, expected a point of the plate of 0.297 x 0.21 m"),
    (lambda: foci(places={**PLACES, "same": Place(0.12, 0.093)}),
     "PlacedFoci.places.same: found the point of middle, (0.12, 0.093) m, expected a different point"),
    (lambda: foci(places={**PLACES, "far": 0.2}), "PlacedFoci.places.far: found 0.2, expected a Place"),
    (lambda: foci(places={"index": Place()}), "PlacedFoci.places: found 1 of them, expected at least two"),
    (lambda: foci(places={**PLACES, "a+b": Place(0.2)}),
     "PlacedFoci.places: found 'a+b', expected a name on one line without '+'"),
    (lambda: FingersSensation(SETUP, PLACES, ("index", "index")),
     "FingersSensation.fingers[1]: found 'index' twice, expected each place once, as two fingers do not fit there"),
    (lambda: FingersSensation(SETUP, PLACES, ("ring",)),
     "FingersSensation.fingers: found 'ring', expected one of index, middle, near"),
    (lambda: FingersSensation(SETUP, PLACES, ("index", "near")),
     "FingersSensation.fingers: found index and near 5 mm apart, expected at least the 10 mm of a fingertip; move a"),
    (lambda: FocusReading(SETUP, contactor="hand"),
     "FocusReading.contactor: found 'hand', expected one of finger, soft, rigid"),
    (lambda: FocusReading(SETUP, x_m=-0.1), "FocusReading.x_m, y_m: found (-0.1, 0.093) m, expected a point of the"),
]  # fmt: skip
CONTACTS = [
    (lambda: Contactor("wet"), "Contactor.kind: found 'wet', expected one of finger, soft, rigid"),
    (lambda: Contactor("soft").loads(A4_SCREEN, (9.0, 9.0), 1.0),
     "at_m: found (9.0, 9.0) m, expected a point of the plate of 0.297 x 0.21 m"),
    (lambda: Contactor("finger").loads(A4_SCREEN, (9.0, 9.0), 1.0),
     "at_m: found (9.0, 9.0) m, expected a point of the plate of 0.297 x 0.21 m"),
    (lambda: loaded_responses(SCREEN, [AT_TIP], [PlateLoad(1.0, 0.1)], **SAMPLING),
     "PlateLoad: found (1.0, 0.1) m, expected a point of the plate of 0.297 x 0.21 m"),
    (lambda: opened(Fingertip(mass_kg=1e-4)), "one_sided_contact.finger: found a mass of 5e-05 kg and a resistance of"),
    (lambda: opened(Fingertip(0.0, stiffness_n_per_m=1e3)),
     "one_sided_contact.finger: found a mass of 0.0 kg and a resistance of 0.0 N s/m, expected no mass and a"),
    (lambda: PulpLoad(2e-3, 0.1, 6e-3).weights(A4_PROTOTYPE, 1e3),
     "PulpLoad: found (-0.0026"),
    (lambda: Fingertip(impedance="tissue").load(AT_TIP),
     "Fingertip.impedance: found 'tissue', expected 'lumped' where contacts open; a contact of tissue is linear"),
    (lambda: disc_stiffness(np.array([2e5j * np.pi]), 6e-3, Tissue(shear_modulus_pa=10.0, shear_viscosity_pa_s=0.0)),
     "disc_stiffness: s, radius_m: found 3.86e+04, expected at most 4096 radii in shear waves; raise the shear"),
]  # fmt: skip
DESIGNS = [
    (lambda: recommended(5000, 30e-3), "Transducers: found 5000 patches of 30 mm, expected at most 28 along the edges"),
    (lambda: recommended(1, 0.5), "Transducers: found 1 patches of 500 mm, expected at most 0 along the edges of the"),
    (lambda: Design(A4_SCREEN, Transducers(n_held(A4_SCREEN, 35e-3) + 1, 35e-3), Band(1e3, 25e3), 3e-3, 6e-3),
     "Transducers: found 25 patches of 35 mm, expected at most 24 along the edges of the plate; use fewer or smaller"),
    (lambda: resolution_m(A4_SCREEN, Band(0.0, 1e3), 0.0),
     "resolution_m.level: found 0.0, expected a number above 0 and below 1"),
    (lambda: resolution_m(A4_SCREEN, Band(0.0, 1e3), 1.0),
     "resolution_m.level: found 1.0, expected a number above 0 and below 1"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("call", "message"),
    [*PLATES, *RESPONSES, *FOCUSING, *STIMULI, *CONTACTS, *DESIGNS],
)
def test_argument_outside_its_domain_is_refused(call, message):
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)
