"""Every stimulus, procedure, protocol, observer and rig: the laws of test_laws.py run over these tables.

A thing that is added gets one line here; tasks come by themselves.
"""

import io
from dataclasses import replace
from functools import cache

import numpy as np
from benches import gain_table
from places import ROOT
from scene_cases import LEVEL, SLIDING, VOLT, default, effect, panel, screen, small_screen

from tactometry.config.strict import build
from tactometry.contact import Contact
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.experiments.study import task_table
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.kinds import PROCEDURES as KINDS
from tactometry.experiments.study.study_file import builtin, load
from tactometry.loading import resolve
from tactometry.observers.finger import SimulatedFinger
from tactometry.observers.signal_detection import SignalDetectionObserver
from tactometry.protocols import (
    Block,
    Condition,
    ConstantStimuli,
    ForcedChoice,
    MethodOfLimits,
    Pressing,
    Quest,
    QuestPlus,
    Rating,
    Sliding,
    Staircase,
    Track,
    WeightedStaircase,
    YesNo,
    session,
)
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid
from tactometry.protocols.bayesian.quest_plus import SharedQuestPlus
from tactometry.protocols.bayesian.settings import PsiSettings
from tactometry.protocols.block import run_block
from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.session import Inquiry
from tactometry.protocols.tasks.task import Alternative
from tactometry.provenance import sha256
from tactometry.questionnaire import load as load_form
from tactometry.rigs.console import Console
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.simulated import SimulatedRig
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.signal import Signal
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.electrovibration import AmplitudeModulated, Grating, Sine, Square, Step, Trapezoid
from tactometry.stimuli.electrovibration.attraction.offset import WithOffset
from tactometry.stimuli.electrovibration.textures.followed_texture import FollowedTexture
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS
from tactometry.stimuli.electrovibration.waveforms.sampled import Sampled
from tactometry.stimuli.electrovibration.waveforms.wav_file import WavFile
from tactometry.stimuli.hybrid import Hybrid
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.hybrid import HybridScreen
from tactometry.stimuli.time_reversal.responses.responses import Responses
from tactometry.stimuli.time_reversal.stimulus.focus_train import FocusTrain, TimeReversalStimulus
from tactometry.stimuli.time_reversal.stimulus.placed_foci import Place, PlacedFoci
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

LIMITS = Limits(voltage_peak_v=200.0)
BUZZ = ROOT / "tests" / "recorded" / "buzz.wav"
"""A voltage of 100 Hz with its third harmonic, 16 bits."""

STIMULI = {
    **{kind: resolve(waveform.target)(**waveform.example, duration_s=0.2) for kind, waveform in WAVEFORMS.items()},
    "amplitude_modulated": AmplitudeModulated(frequency_hz=240.0, duration_s=0.2),
    "amplitude_modulated_full": AmplitudeModulated(frequency_hz=240.0, duration_s=0.2, modulation="full"),
    "amplitude_modulated_suppressed": AmplitudeModulated(
        frequency_hz=120.0, duration_s=0.2, modulation="suppressed_carrier"
    ),
    "square_band_limited": Square(frequency_hz=60.0, duration_s=0.2, band_limited=True),
    "trapezoid": Trapezoid(rise_s=0.002, high_s=0.003, fall_s=0.004, low_s=0.001, duration_s=0.2, ramp_s=0.05),
    "step": Step(onset_s=0.01, rise_s=0.01, fall_s=0.01, duration_s=0.2),
    "sampled": Sampled((0.0, 1.0, -2.0, 0.5, 0.0), rate_hz=100.0, ramp_s=0.0),
    "texture": FollowedTexture(Grating(1e-3, "sinusoidal"), duration_s=0.2),
    "wav": WavFile(
        str(BUZZ), rate_hz=8e3, duration_s=0.2, sha256=sha256(BUZZ.read_bytes()), level_unit="dB re 1 V", ramp_s=0.01
    ),
    "with_offset": WithOffset(Sine(frequency_hz=60.0, duration_s=0.2), ratio=0.5),
    "time_reversal": TimeReversalStimulus(
        Responses(1e-9 * np.array([[[0.0, 3.0, -2.0, 1.0, 0.5]]]), 1e6), voltage_max_v=1e9, level_unit="dB re 1 um"
    ),
    "focus_train": FocusTrain(
        Setup(n_transducers=2, modes_to_hz=10e3, rate_hz=25e3), pattern="P1", f_max_hz=10e3, voltage_max_v=1e9
    ),
    "foci": PlacedFoci(
        Setup(n_transducers=2, modes_to_hz=10e3, rate_hz=25e3),
        f_max_hz=10e3,
        voltage_max_v=1e9,
        places={"index": Place(0.1), "middle": Place(0.12)},
        place="index + middle",
    ),
    "hybrid": Hybrid(
        FocusTrain(Setup(n_transducers=2, modes_to_hz=10e3, rate_hz=25e3), f_max_hz=10e3, voltage_max_v=1e9),
        AmplitudeModulated(frequency_hz=120.0, duration_s=0.5, rate_hz=25e3),
    ),
}

RUBBED = (default("skin_leakage"), default("contact_area"), default("friction"))
FOCUSED = (effect("attenuation", tau_s=2e-3), effect("one_bit"), effect("finger_load"))

SCENES = {
    "electrovibration": panel(*RUBBED, outputs=("t_s", "friction_force_n")),
    "time_reversal": screen(*FOCUSED, outputs=("t_s", "focus_displacement_m")),
    "hybrid": Scene(
        HybridScreen(Electrovibration(60.0, duration_s=0.05, ramp_s=0.01), small_screen()),
        (*FOCUSED, default("force_law"), *RUBBED),
        ("peak_m", "sliding_t_s", "friction_force_n"),
        contacts=(FingerContact(2.0), replace(SLIDING[0], x_m=0.09, y_m=0.06)),
    ),
}
GIVEN = {**LEVEL, **VOLT}

PROCEDURES = {
    **{name: kind.rule_of(build(resolve(kind.table), kind.example, name)) for name, kind in KINDS.items()},
    "weighted_staircase": WeightedStaircase(
        start=30.0, steps_up=(6.0, 3.0), steps_down=(2.0, 1.0), low=0.0, high=40.0, n_trials=40
    ),
    "quest_plus": QuestPlus(
        tuple(float(x) for x in range(0, 41, 2)), ParameterGrid(tuple(range(0, 41, 2)), (4.0, 8.0)), n_trials=20
    ),
    "quest_plus_threshold": QuestPlus(
        tuple(float(x) for x in range(0, 41, 2)),
        ParameterGrid(tuple(range(0, 41, 2)), (4.0, 8.0), lapse_rates=(0.0, 0.04)),
        n_trials=20,
        sd_stop=3.0,
        aim="threshold",
    ),
    "quest_plus_variance": QuestPlus(
        tuple(float(x) for x in range(0, 41, 2)),
        ParameterGrid(tuple(range(0, 41, 2)), (4.0, 8.0), lapse_rates=(0.0, 0.04)),
        n_trials=20,
        criterion="variance",
    ),
    "quest_plus_shared": SharedQuestPlus(
        QuestPlus(
            tuple(float(x) for x in range(0, 41, 2)), ParameterGrid(tuple(range(0, 41, 2)), (4.0, 8.0)), n_trials=20
        ),
        ("first", "second"),
    ).procedures()[0],
    "psi": PsiSettings(low=0.0, high=40.0, n_levels=21, sd_low=1.0, sd_high=8.0, n_sds=3, n_trials=20).procedure(),
    "quest": Quest(start=20.0, start_sd=10.0, low=0.0, high=40.0, step=1.0, n_trials=20),
    "method_of_limits": MethodOfLimits(low=0.0, high=40.0, step=5.0, n_series=4),
    "method_of_limits_ascending": MethodOfLimits(
        low=0.0, high=40.0, step=5.0, n_series=4, direction="ascending", n_start_steps=2
    ).begin(np.random.default_rng(0)),
    "constant_stimuli": ConstantStimuli(levels=(10.0, 20.0, 30.0), repeats=4),
    "constant_stimuli_shuffled": ConstantStimuli(levels=(10.0, 20.0, 30.0), repeats=4).begin(np.random.default_rng(0)),
    "staircase_1_up_1_down": Staircase(
        start=30.0, steps=(4.0, 2.0), low=0.0, high=40.0, n_down=1, n_reversals=6, n_trials=30
    ),
    "staircase_1_up_2_down": Staircase(
        start=30.0, steps=(8.0, 4.0, 2.0), low=0.0, high=40.0, n_down=2, n_reversals=8, n_trials=40
    ),
    "staircase_2_up_3_down_no_initial_rule": Staircase(
        start=20.0, steps=(3.0,), low=0.0, high=40.0, n_up=2, n_down=3, n_trials=40, initial_rule=False
    ),
}

TOUCHES = {
    "press": Pressing(duration_s=0.2, force_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=5.0),
    "slide": Sliding(duration_s=0.2, force_n=1.0, tolerance=0.2, hold_s=0.1, timeout_s=5.0, speed_m_per_s=0.05),
}

REGISTERED = {
    name: kind.made(build(kind.table, kind.example, "task"), load_form) for name, kind in task_table.TASKS.items()
}
TASKS = {
    **REGISTERED,
    "four_interval": ForcedChoice(4),
    "rating": Rating(load_form("attrakdiff-haptic"), shuffled=True, n_touches=2),
    "rating_statements": Rating(load_form("sus")),
}
DETECTION = ("yes_no", "forced_choice", "four_interval")
PLACES = tuple(Alternative(f"place {n}", str(n), {"frequency_hz": 60.0 * n}) for n in (1, 2))


def block(task, procedure, touch="slide", stimulus="amplitude_modulated"):
    """A block of the catalogue's parts, by their names."""
    condition = Condition({"frequency_hz": 240.0}, stimulus, "dB re 1 V", TOUCHES[touch], alternatives=PLACES)
    catch_rate = 0.25 if TASKS[task].takes_catch_trials else 0.0
    return Block((Track(condition, PROCEDURES[procedure]),), TASKS[task], BlockOptions(catch_rate))


def interleaved(interleaving):
    """Three procedures in one block, with feedback and rests."""
    condition = Condition({"frequency_hz": 240.0}, "amplitude_modulated", "dB re 1 V", TOUCHES["press"])
    names = ("constant_stimuli", "staircase_1_up_1_down", "quest_plus")
    tracks = tuple(Track(condition, PROCEDURES[name], name) for name in names)
    options = BlockOptions(0.25, interleaving=interleaving, feedback=True, rest_after=20, longest_s=1e4)
    return Block(tracks, YesNo(), options)


def _one_block(task, procedure):
    return lambda rng: run_block(block(task, procedure), 1, 1, rng)


def _built_in(name):
    wired = cache(lambda: wire(load(name)[0], name))
    return lambda rng: session(wired().parts(1, rng)[:3], rng)


PROTOCOLS = {
    **{f"{task} x {rule}": _one_block(task, rule) for task in DETECTION for rule in PROCEDURES},
    **{task: _one_block(task, "constant_stimuli_shuffled") for task in TASKS if task not in DETECTION},
    "session": lambda rng: session([block("yes_no", rule) for rule in PROCEDURES], rng),
    "interleaved": lambda rng: session([interleaved("random"), Inquiry(load_form("nasa-tlx"))], rng),
    "interleaved in rounds": lambda rng: session([interleaved("balanced")], rng, longest_s=3600.0),
    **{name: _built_in(name) for name in builtin()},
}

OBSERVERS = {
    "default": SignalDetectionObserver(),
    "keen": SignalDetectionObserver(sensitivity_db=20.0, lapse_rate=0.0),
    "numb": SignalDetectionObserver(sensitivity_db=-400.0),
    "lax": SignalDetectionObserver(criterion=0.1, exponent=3.0),
}


class Loudness:
    """A sensation that is the peak in dB re 1 V, for protocols whose stimuli are of no matter."""

    def sensation_db(self, signal: Signal, contact: Contact) -> float:
        del contact
        return 20 * float(np.log10(signal.peak)) - 20.0 if signal.peak > 0 else -np.inf


class AnyStimulus(dict):
    """A bank in which every name is a short tone."""

    def __contains__(self, name):
        return True

    def __missing__(self, name):
        return replace(STIMULI["amplitude_modulated"], duration_s=0.1)


def simulated(seed=0, observer="default", *, limits=LIMITS, sensation=None, finger=None):
    """A simulated rig for any protocol."""
    return SimulatedRig(
        AnyStimulus(),
        limits,
        sensation=sensation or Loudness(),
        observer=OBSERVERS[observer],
        finger=finger or SimulatedFinger(),
        rng_of=lambda n_trials: np.random.default_rng([seed, n_trials]),
        decisions=task_table.DECISIONS,
    )


def silent(bank, limits):
    """The equipment of a console that plays nothing."""
    return Equipment(Guarded(NullOutput(), limits), bank, limits)


def console(seed=0):
    """A console with an endless input."""
    return Console(silent(AnyStimulus(), LIMITS), texts_in("en", {}), Answers(seed), io.StringIO())


class Answers(io.StringIO):
    """An input of 1 and 0 in turn: one of the two answers every question."""

    def __init__(self, seed):
        super().__init__()
        self.n_lines = seed

    def readline(self, size=-1):
        del size
        self.n_lines += 1
        return f"{self.n_lines % 2}\n"

    def isatty(self):
        return False


RIG_MAKERS = {"simulated": simulated, "console": console}

OUTPUTS = {
    "null": {"kind": "null"},
    "file": {"kind": "file", "folder": "played"},
    "wav": {"kind": "file", "folder": "played", "format": "wav"},
    "packed": {
        "kind": "packed",
        "path": "board",
        "n_channels": 2,
        "rate_hz": 1e6,
        "gain": gain_table("packed board", 30.0, 1.0),
    },
    "audio": {
        "kind": "audio",
        "device": "tofile",
        "channels": [0, 1],
        "rate_hz": 48e3,
        "gain": gain_table("audio tofile, int32", 30.0, 1.0),
    },
}
"""Outputs of a bench file; files are in the working folder."""

SENSORS = {
    "serial": {"kind": "serial", "rate_hz": 1000.0, "n_channels": 3},
    "udp": {"kind": "udp", "rate_hz": 1000.0, "address": "127.0.0.1"},
    "lsl": {"kind": "lsl", "rate_hz": 1000.0, "n_channels": 3},
    "recorded": {"kind": "recorded", "path": "recording.csv", "rate_hz": 100.0},
}
"""Sensors of a bench file; the address of an emulator is filled in."""
