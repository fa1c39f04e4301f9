"""Reference tables of study, scene and plate files."""

from collections.abc import Callable, Iterator, Mapping
from operator import methodcaller
from typing import Any, Final

from tactometry.loading import resolve
from tactometry.stimuli.electrovibration.textures.kinds import TEXTURES
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.surfaces import SURFACES
from tactometry.trials.tasks import TASKS

from ..study.kinds import PROCEDURES, STIMULI, TOUCHES, ProcedureKind, StimulusKind
from .tables import KeyTable, Values

STUDY: Final[Values] = {
    "name": "own-study",
    "title": "A study of one's own",
    "description": "Is a tone of 240 Hz felt?",
    "task": {"kind": "yes_no"},
    "factors": {"frequency_hz": [240.0]},
    "stimulus": {"kind": "sine", "duration_s": 0.5},
    "touch": {"kind": "slide", "force_n": 1.0, "speed_m_per_s": 0.05, "hold_s": 0.3, "timeout_s": 10.0},
    "procedure": {"kind": "staircase", "start": 30.0, "steps": [4.0, 2.0], "low": 0.0, "high": 40.0},
    "limits": {"voltage_peak_v": 200.0},
}
IN_LEVELS: Final = (
    "start", "steps", "steps_up", "steps_down", "step", "low", "high", "levels", "start_sd", "sd_stop", "decade",
    "width_low", "width_high", "threshold_low", "threshold_high", "sd_low", "sd_high", "standard_level",
)  # fmt: skip
"""Keys of tasks and procedures whose unit is that of the level."""
DIGEST: Final = "0" * 64
GREY: Final = b"0.0,1.0,0.2\n"
DIGEST_OF_GREY: Final = "1616722295ff490c80645639722a0ae30a51486425741b5a399a407d6130d750"
"""Content of a file of grey levels, and its digest."""
PLACES: Final[Values] = {"index": {"x_m": 0.10}, "middle": {"x_m": 0.13}}
_OF_STUDY: Final[Values] = {
    "counterbalance": ["frequency_hz"],
    "variants": {"frequency_hz": {"240": {"stimulus": {"duration_s": 0.3}}}},
    "texts": {"felt": "Was there a buzz?"},
    "translations": {"fr": {"felt": "Y avait-il un bourdonnement ?"}},
}
_NESTED: Final[Values] = {
    **STUDY,
    "factors": {"frequency_hz": [60.0, 240.0], "force_n": [0.5, 1.0]},
    "nested": {"frequency_hz": {"240": {"force_n": [1.0]}}},
}
_TRAIN: Final[Values] = {
    "reversal_s": 2e-3,
    "repetition_hz": 200.0,
    "envelope": "rectangular",
    "train_s": 0.05,
    "envelope_table": [0.5, 1.0, 0.5],
    "supply_v": 100.0,
}
_FILE: Final[Values] = {"path": "buzz.wav", "rate_hz": 48e3, "duration_s": 0.5}
_EXAMPLES: Final[Mapping[str, Values]] = {
    **{kind: wave.example for kind, wave in WAVEFORMS.items()},
    "foci": {"places": PLACES, "place": "index"},
    "hybrid": {"focus": {}, "friction": {"frequency_hz": 120.0, "duration_s": 0.5, "rate_hz": 250e3}},
    "texture": {"texture": {"kind": "grating", "period_m": 1e-3}},
    "wav": _FILE,
}
_SAMPLES: Final[Values] = {**_TRAIN, "sha256": DIGEST}
_NOTES: Final[Mapping[str, str]] = {
    "pattern": "`pattern` says which train it is.",
    "measured_focus": "Nobody feels a `measured_focus`: a vibrometer reads it, under what `[sensation]` says.",
}
_PRESS: Final[Values] = {"force_n": 1.0, "hold_s": 0.3, "timeout_s": 10.0}
_OF_TOUCH: Final[Values] = {"tolerance": 0.15, "speed_tolerance": 0.3}
_OF_PROCEDURE: Final[Values] = {
    "sd_stop": 1.0, "width_prior_factor": 2.0, "threshold_low": 5.0, "threshold_high": 35.0, "n_thresholds": 31,
}  # fmt: skip
_OF_LIMITS: Final[Values] = {
    "duration_s": 10.0, "current_peak_a": 1e-3, "charge_peak_c": 1e-6, "displacement_peak_m": 2e-5, "duty": 0.5,
    "session_s": 2700.0, "charge_session_c": 1e-3, "stop_within_s": 0.06,
}  # fmt: skip
_OF_EXCLUSION: Final[Values] = {
    "force_in_band_share_min": 0.8, "force_deviation_ratio_max": 0.2, "latency_min_s": 0.15, "latency_max_s": 10.0,
    "false_alarm_share_max": 0.3, "invalid_share_max": 0.2,
}  # fmt: skip
_OF_PLAN: Final[Values] = {
    "between": ["waveform"], "sessions": ["force_n"], "interleave": ["frequency_hz"], "longest_s": 3600.0,
    "orders": {"random": ["frequency_hz"]},
}  # fmt: skip
_OF_SCENE: Final[Values] = {
    "name": "electrovibration-panel",
    "surface": {"insulator_thickness_m": 2e-6},
    "effects": [{"kind": "force_law", "law": "sc_layer"}, {"kind": "friction"}, {"kind": "sensitivity"}],
}
_PLACED: Final = "tactometry.stimuli.time_reversal.stimulus"


def study_tables() -> Iterator[KeyTable]:
    """Yield reference tables of a study, except observers and questionnaires."""
    read = "tactometry.experiments.study"
    study = f"{read}.study:Study"
    yield KeyTable("study", "", study, example=STUDY, samples=_OF_STUDY, instead={"nested": _NESTED})
    yield from (_stimulus(kind, known) for kind, known in STIMULI.items())
    yield KeyTable("stimulus.setup", "[stimulus.setup]", f"{_PLACED}.setup:Setup", samples={"shear_factor": 0.8333})
    place = {"x_m": 0.1, "y_m": 0.1}
    yield KeyTable("stimulus.places", "[stimulus.places.NAME]", f"{_PLACED}.placed_foci:Place", samples=place)
    yield from _textures()
    yield from (_touch(kind, target) for kind, target in TOUCHES.items())
    options, rests = "tactometry.protocols.block_state:BlockOptions", {"rest_after": 20, "rest_every_s": 600.0}
    rests |= {"rest_s": 30.0, "longest_s": 1800.0}
    yield KeyTable("task", "[task]", options, samples=rests, also=("task.prompt",))
    yield KeyTable("task.prompt", "[task]", f"{read}.prompts:PromptTable", samples={"prompt": "Was there a buzz?"})
    yield from map(_task, TASKS)
    practice = "tactometry.protocols.procedures.practice:Practice"
    yield KeyTable("practice", "[practice]", practice, example={"levels": [40.0]}, in_levels=IN_LEVELS)
    yield KeyTable("plan", "[plan]", f"{read}.study:PlanTable", samples=_OF_PLAN)
    image, of_image = "tactometry.rigs.texts:ImageTable", {"path": "setup.png"}
    yield KeyTable("images", "[images.MESSAGE]", image, example=of_image, samples={"sha256": DIGEST})
    yield limits("limits", "[limits]")
    yield KeyTable("study.scene", "[scene]", f"{read}.felt_scene:SceneTable", samples=_OF_SCENE)
    yield from _surfaces()
    yield from analysis_tables("analysis", "[analysis]")


def procedure_tables() -> Iterator[KeyTable]:
    """Yield the reference table `[procedure]` of each kind."""
    yield from (_procedure(kind, known) for kind, known in PROCEDURES.items())
    shared = "tactometry.experiments.study.procedure_table:TracksTable"
    yield KeyTable("procedure", "[procedure]", shared, samples={"easy_level": 40.0})


def limits(name: str, header: str) -> KeyTable:
    """Yield the reference table of limits, in a study or bench."""
    example = {"voltage_peak_v": 200.0}
    return KeyTable(name, header, "tactometry.safety.limits:Limits", example=example, samples=_OF_LIMITS)


def analysis_tables(name: str, header: str) -> Iterator[KeyTable]:
    """Yield the reference tables of an analysis plan."""
    samples = {"equivalence": {"force_n": 1.0}, "primary": "anova"}
    yield KeyTable(name, header, "tactometry.analysis.plan:AnalysisPlan", samples=samples)
    inner = "[exclusion]" if not header else f"{header[:-1]}.exclusion]"
    read = "tactometry.analysis.reading.quality:Exclusion"
    yield KeyTable(f"{name}.exclusion", inner, read, samples=_OF_EXCLUSION)


def _stimulus(kind: str, known: StimulusKind) -> KeyTable:
    return KeyTable(
        f"stimulus.{kind}",
        "[stimulus]",
        known.stimulus,
        kind,
        note=_NOTES.get(kind, ""),
        example=_EXAMPLES.get(kind, {}),
        samples=_SAMPLES,
        instead={"volts_per_unit": {**_FILE, "level_unit": "dB re file", "volts_per_unit": 10.0}},
        given=lambda: {"read": False} if known.reads else {},
        kinds=known.parts,
    )


def _surfaces() -> Iterator[KeyTable]:
    """Yield the reference tables of `[scene.surface]` in a study."""
    header, surfaces = "[scene.surface]", "tactometry.stimuli.scenes.surfaces"
    finger = {"finger_x_m": 0.1, "finger_y_m": 0.1}
    plate, fingers = f"{surfaces}.played_plates:PlayedTimeReversal", f"{surfaces}.played_plates:PlayedFingers"
    yield KeyTable("study.scene.surface.time_reversal", header, plate, samples=finger, given=stimulus_gives("setup"))
    on_places = stimulus_gives("setup", "places")
    yield KeyTable("study.scene.surface.foci", header, fingers, samples={"fingers": ["index"]}, given=on_places)
    yield KeyTable(
        "study.scene.finger", "[scene.surface.finger]", "tactometry.stimuli.time_reversal.fingertip:Fingertip"
    )


def stimulus_gives(*names: str) -> Callable[[], Values]:
    """Return a function that supplies fields set by the stimulus."""

    def made() -> Values:
        known: dict[str, Any] = {
            "setup": resolve(f"{_PLACED}.setup:Setup")(n_transducers=4, modes_to_hz=4e3, rate_hz=10e3),
            "places": {name: resolve(f"{_PLACED}.placed_foci:Place")(**at) for name, at in PLACES.items()},
        }
        return {name: known[name] for name in names}

    return made


def _textures() -> Iterator[KeyTable]:
    """Yield the reference tables of textures in `[stimulus]`."""
    for kind, texture in TEXTURES.items():
        name, header = f"texture.{kind}", "[stimulus.texture]"
        from_file = {"pixel_m": 1e-3, "path": "grey.csv", "sha256": DIGEST_OF_GREY}
        instead = {"path": from_file, "sha256": from_file}
        yield KeyTable(name, header, texture.target, kind, example=texture.example, instead=instead)


def _touch(kind: str, target: str) -> KeyTable:
    example = {**_PRESS, "speed_m_per_s": 0.05} if kind == "slide" else _PRESS
    name, given = f"touch.{kind}", lambda: {"duration_s": 0.5}
    return KeyTable(name, "[touch]", target, kind, example=example, samples=_OF_TOUCH, given=given)


def _task(kind: str) -> KeyTable:
    task = f"tactometry.protocols.tasks.{kind}:TASK"
    return KeyTable(
        f"task.{kind}",
        "[task]",
        f"{task}.table",
        kind,
        example=f"{task}.example",
        samples={"high": 100.0},
        also=("task", "task.prompt"),
        in_levels=("step", "low", "high", "standard_level") if kind != "magnitude" else (),
    )


def _procedure(kind: str, known: ProcedureKind) -> KeyTable:
    made: Any = methodcaller(known.rule) if known.rule else (lambda table: table)
    return KeyTable(
        f"procedure.{kind}",
        "[procedure]",
        known.table,
        kind,
        example=known.example,
        samples=_OF_PROCEDURE,
        also=("procedure",) if known.takes_easy_trials else (),
        made=made,
        in_levels=IN_LEVELS,
    )


_SURFACES: Final[Mapping[str, Values]] = {
    "electrovibration": {"frequency_hz": 240.0},
    "hybrid": {"electrovibration": {"frequency_hz": 240.0}},
}
_EFFECTS: Final[Mapping[str, Values]] = {
    "dc_offset": {"ratio": 0.5},
    "texture": {"period_m": 1e-3},
    "body_resistance": {"resistance_ohm": 1e4},
    "air_gap": {"gap_m": 1e-6},
    "force_law": {"law": "sc_layer"},
    "polarity": {"positive_share": 0.5},
    "masking": {"level_db_re_threshold": 25.0},
    "edges": {"boundary": "FFFF"},
    "attenuation": {"tau_s": 3.5e-3},
    "foci": {"x_m": [0.2], "y_m": [0.1]},
    "temperature_drift": {"kelvin": 10.0},
    "pulse_width": {"carrier_hz": 1e5},
    "cross_masking": {"target": "foci"},
}
_SCENE: Final[Values] = {
    "outputs": ["voltage_v", "t_s"],
    "surface": {"kind": "electrovibration", "frequency_hz": 240.0},
}
_OF_SCENE_FILE: Final[Values] = {
    "effects": [{"kind": "force_law", "law": "sc_layer"}],
    "contacts": [{"force_n": 1.0, "speed_m_per_s": 0.05}],
    "given": {"level_db_re_1v": 40.0},
    "settings": {"sampling": {"rate_hz": 20e3}},
}
_PLATE: Final[Values] = {
    "length_m": 0.297, "width_m": 0.210, "thickness_m": 1.1e-3, "youngs_modulus_pa": 64e9, "poisson_ratio": 0.2,
    "density_kg_per_m3": 2230.0, "boundary": "FFFF",
}  # fmt: skip


def scene_tables() -> Iterator[KeyTable]:
    """Yield reference tables of a scene file: surface, fingers and effects."""
    composed = "tactometry.stimuli.composition.effect:FingerContact"
    place = {"x_m": 0.1, "y_m": 0.1}
    read = "tactometry.stimuli.scenes.file:SceneTables"
    yield KeyTable("scene", "", read, example=_SCENE, samples=_OF_SCENE_FILE)
    for kind, target in SURFACES.items():
        yield KeyTable(f"scene.surface.{kind}", "[surface]", target, kind, example=_SURFACES.get(kind, {}))
    yield KeyTable("scene.contacts", "[[contacts]]", composed, example={"force_n": 1.0}, samples=place)
    yield from (_effect(kind, target) for kind, target in EFFECTS.items())


def _effect(kind: str, target: str) -> KeyTable:
    name, samples = f"scene.effects.{kind}", {"n_frames": 60}
    return KeyTable(name, "[[effects]]", target, kind, example=_EFFECTS.get(kind, {}), samples=samples)


def plate_tables() -> Iterator[KeyTable]:
    """Yield the reference tables of a plate file."""
    plate = "tactometry.stimuli.time_reversal.plate"
    yield KeyTable("plate", "", f"{plate}.plate:Plate", example=_PLATE, also=("plate.glass",))
    yield KeyTable("plate.glass", "", f"{plate}.glass:NamedGlass", example={"glass": "Borofloat 33"})
