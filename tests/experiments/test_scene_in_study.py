"""`[scene]` in a study file: what simulated participants feel, what the commands tell of it, and what is refused."""

import json
import os
import re
import subprocess
import sys

import electrovibration_formula
import hybrid_formula
import pytest
import time_reversal_formula
from command_line import call, output
from places import DOCS, ROOT
from scene_cases import ELECTROVIBRATION, TIME_REVERSAL
from study_texts import changed, wired

from tactometry.config.strict import build
from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.cells import STIMULI
from tactometry.experiments.study.felt_effects import felt_effects
from tactometry.experiments.study.felt_scene import FeltScene
from tactometry.experiments.study.scene_table import felt_scene
from tactometry.experiments.study.study_file import builtin, load
from tactometry.loading import resolve
from tactometry.records.head import heads
from tactometry.stimuli.scenes.effects import EFFECTS, OF_ELECTROVIBRATION, OF_TIME_REVERSAL
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation

TUTORIAL = load("tutorial")[1].decode()
FOCI = load("time-reversal-threshold")[1].decode()
CASES = {**ELECTROVIBRATION, **TIME_REVERSAL}
EFFECT_LINES = {
    "force_law": '{ kind = "force_law", law = "sc_layer" }',
    "friction": '{ kind = "friction" }',
    "sensitivity": '{ kind = "sensitivity" }',
}


def scene(*lines, **keys):
    effects = ", ".join(lines or EFFECT_LINES.values())
    more = "".join(f"{key} = {value}\n" for key, value in keys.items())
    return f"{TUTORIAL}\n[scene]\n{more}effects = [{effects}]\n"


def named(name, more=""):
    return f'{TUTORIAL}\n[scene]\nname = "{name}"\n{more}'


def felt_db(text, level=30.0):
    cell = next(iter(wired(text).cells.values()))
    return cell.sensation.sensation_db(cell.stimulus.at(level), Contact(1.0, 0.05))


LEAKY = ("skin_leakage", "contact_area", "force_law", "friction", "friction_lag")
CONTACTS = (Contact(1.5), Contact(0.5, 0.02), Contact(3.0, 0.1))


FORMULAS = {
    "ElectrovibrationSensation": electrovibration_formula.level_db,
    "TimeReversalSensation": time_reversal_formula.level_db,
    "FingersSensation": time_reversal_formula.strongest_db,
    "HybridSensation": hybrid_formula.level_db,
}


def model_of(cell, **numbers):
    """What `[sensation]` states of a cell."""
    kind = STIMULI[cell.condition.stimulus.partition(",")[0]]
    shared = {name: getattr(cell.stimulus, name) for name in kind.shared}
    return build(resolve(kind.sensation), numbers, "sensation", **shared)


@pytest.mark.parametrize("study", builtin())
def test_each_stimulus_of_a_built_in_study_is_felt_by_its_scene_as_by_its_formula(study):
    experiment = wired(load(study)[1].decode())
    cells = {cell.condition.stimulus: cell for cell in experiment.cells.values()}
    for cell in cells.values():
        if isinstance(cell.sensation, FeltScene):
            signal, model = cell.stimulus.at(12.0), model_of(cell, **experiment.study.sensation)
            formula_db = FORMULAS[type(model).__name__]
            levels_db = [cell.sensation.sensation_db(signal, contact) for contact in CONTACTS]
            assert levels_db == pytest.approx([formula_db(model, signal, touch) for touch in CONTACTS], abs=1e-12)


SENSATIONS = {
    "leak": ("skin = { corneum_resistivity_ohm_m = 1e3 }", "skin_leakage"),
    "conductor": ("skin = { corneum_resistivity_ohm_m = 0 }\nlaw = 'interface'", ""),
    "gap": ('skin = { gap_m = "1 um" }', "air_gap"),
    "body": ("skin = { body_resistance_ohm = 2e4 }", "body_resistance"),
    "tissue": ('skin = { tissue = { thickness_m = "5 mm", permittivity = 1e4, resistivity_ohm_m = 50 } }', ""),
    "law": ("law = 'total_thickness'", "force_law"),
    "friction": ("friction = { coefficient = 0.2, load_exponent = -0.3 }", "friction"),
    "lag": ("lag = { floor_hz = 30.0, slope_hz_per_m_per_s = 0.0 }", "friction_lag"),
    "polarity": ("polarity = { positive_share = 0.25 }", "polarity"),
    "fraction": ("criterion = 'fraction'", "weber_fraction"),
}


@pytest.mark.parametrize("name", SENSATIONS)
def test_each_key_of_the_formula_is_that_of_an_effect(name):
    keys, kind = SENSATIONS[name]
    study = wired(f"{TUTORIAL}\n[sensation]\n{keys}\n")
    cell, plain, stated = next(iter(study.cells.values())), wired(TUTORIAL).sensation(), study.sensation()
    signal, model = cell.stimulus.at(30.0), model_of(cell, **study.study.sensation)
    for contact in CONTACTS[1:]:
        level_db = stated.sensation_db(signal, contact)
        assert level_db == pytest.approx(electrovibration_formula.level_db(model, signal, contact), abs=1e-12)
        assert level_db != plain.sensation_db(signal, contact)
    assert not kind or kind in {effect.kind for effect in stated.scene.effects}


def test_a_study_tells_the_effects_of_its_default_scene():
    (felt,) = felt_effects(wired(TUTORIAL))
    assert felt.felt == (*LEAKY, "skin_mobility", "sensitivity")


def test_each_effect_of_a_scene_is_felt():
    plain_db = felt_db(scene())
    masked_db = felt_db(scene(*EFFECT_LINES.values(), '{ kind = "masking", level_db_re_threshold = 25.0 }'))
    assert plain_db - masked_db == pytest.approx(0.52 * 25)
    other = [EFFECT_LINES["force_law"], EFFECT_LINES["sensitivity"], '{ kind = "friction", coefficient = 1.0 }']
    assert felt_db(scene(*other)) - plain_db == pytest.approx(6.0206, abs=1e-3)


def test_a_built_in_scene_is_that_of_its_effects_under_the_tone_of_the_study():
    kinds = ("skin_leakage", "contact_area", "friction_lag")
    stated = scene(*EFFECT_LINES.values(), *(f'{{ kind = "{kind}" }}' for kind in kinds))
    assert felt_db(named("electrovibration-panel")) == felt_db(stated)


def test_a_scene_file_is_felt_as_its_tables_and_told_with_what_is_not_at_its_default(tmp_path):
    effects, surface = ", ".join(EFFECT_LINES.values()), '{ insulator_thickness_m = "2 um" }'
    file = tmp_path / "mine.toml"
    tone = '{ kind = "electrovibration", frequency_hz = 60, insulator_thickness_m = "2 um" }'
    contact = "{ force_n = 1.0, speed_m_per_s = 0.05 }"
    file.write_text(
        f"outputs = ['t_s', 'sensation_db']\nsurface = {tone}\ncontacts = [{contact}]\neffects = [{effects}]\n"
    )
    assert felt_db(named(file)) == felt_db(scene(surface=surface))
    told = "force_law (law = sc_layer), friction, sensitivity; insulator_thickness_m = 2e-06; accuracy 0.05"
    assert wired(named(file)).felt == told


def test_keys_of_the_surface_are_those_of_a_scene_file():
    thicker = felt_db(scene(surface='{ insulator_thickness_m = "2 um" }'))
    assert thicker < felt_db(scene())


def test_a_level_of_a_factor_changes_the_scene():
    text = scene() + "\n[variants.frequency_hz.240.scene]\naccuracy = 0.5\n"
    accuracies = [cell.sensation.scene.accuracy for cell in wired(text).cells.values()]
    assert accuracies == [0.05, 0.5]
    assert len(felt_effects(wired(text))) == 2


SENTENCES = {
    "unknown key": (scene(acuracy=0.1), "scene.acuracy: found an unknown key"),
    "unknown effect": (
        scene('{ kind = "frictoin" }'),
        "scene.effects[0].kind: found 'frictoin', expected one of ",
    ),
    "effect of another surface": (
        scene('{ kind = "one_bit" }'),
        "scene.effects[0]: found 'one_bit', which 'electrovibration' does not know, expected an effect of ",
    ),
    "two of one kind": (
        scene(*EFFECT_LINES.values(), '{ kind = "receptors" }'),
        "scene.effects[2]: found 'sensitivity' beside 'receptors', expected one of them: ",
    ),
    "an effect without its need": (
        scene('{ kind = "masking", level_db_re_threshold = 25.0 }', *list(EFFECT_LINES.values())[:2]),
        "scene: outputs: found nothing that gives 'sensation_db'",
    ),
    "no threshold": (
        scene(*list(EFFECT_LINES.values())[:2]),
        "scene: outputs: found nothing that gives 'sensation_db'",
    ),
    "no law": (
        scene(*list(EFFECT_LINES.values())[1:]),
        "add the effect force_law and name one of the four laws",
    ),
    "accuracy out of range": (scene(accuracy=0.0), "scene.accuracy: found 0.0, expected above 0 and at most 1"),
    "accuracy out of reach": (scene(accuracy=1e-12), "loosen the accuracy"),
    "what is played": (
        scene('{ kind = "carrier" }'),
        "scene.effects[0]: found 'carrier', which changes what is played or on what, expected what [stimulus] states",
    ),
    "the tone": (
        scene(surface="{ frequency_hz = 60 }"),
        "scene.surface.frequency_hz: found what [stimulus] states, expected it there alone; remove it",
    ),
    "another surface": (
        scene(surface='{ kind = "time_reversal" }'),
        "scene.surface.kind: found 'time_reversal', expected 'electrovibration', which the stimulus is played on; "
        "where levels of a factor are played on several, state each as [variants.FACTOR.LEVEL.scene]",
    ),
    "unknown scene": (
        named("electrovibration-panle"),
        "scene.name: found 'electrovibration-panle', expected a path or one of a4-screen, electrovibration-panel, "
        "hybrid-screen, thin-screen; did you mean 'electrovibration-panel'?",
    ),
    "no scene file": (named(ROOT / "pyproject.toml"), "pyproject.toml, build-system: found an unknown key"),
    "scene on a plate": (named("a4-screen"), "scene.name: found 'a4-screen', a scene on 'time_reversal', expected one"),
    "both": (
        named("electrovibration-panel", "effects = []\nsurface = { area_m2 = 1e-4 }\n"),
        "scene.name: found 'electrovibration-panel' beside surface or effects, expected one of the two",
    ),
    "sensation too": (
        scene() + "[sensation]\nreference_force_n = 1e-5\n",
        "sensation: found a table beside [scene], expected one of the two",
    ),
    "at rest": (
        changed(scene(), {'kind = "slide"': 'kind = "press"', 'speed_m_per_s = "50 mm/s"\n': ""}),
        "touch.kind: found 'press' with a [scene], expected 'slide'",
    ),
}


@pytest.mark.parametrize("name", SENTENCES)
def test_a_scene_that_cannot_be_felt_is_refused_before_anything_plays(name, tmp_path, capsys):
    text, sentence = SENTENCES[name]
    path = tmp_path / "s.toml"
    path.write_text(text, encoding="utf-8")
    status, said, _ = call(capsys, "simulate", path, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert status == 2
    assert "s.toml, " in said
    assert sentence in said
    assert not (tmp_path / "d").exists()


# --- what the commands tell


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "s.toml"
    text = changed(scene(*EFFECT_LINES.values(), '{ kind = "contact_area" }'), SHORT)
    path.write_text(text, encoding="utf-8")
    return path


SHORT = {"[60, 240]": "[60]", "levels = [22, 28, 34, 40]": "levels = [10, 34]", "repeats = 4": "repeats = 1"}


def test_a_dry_run_tells_what_is_felt_and_what_was_left_out(study, capsys):
    said = output(capsys, "run", study, "--participant", "P01", "--dry-run")
    words = " ".join(said.split())
    assert "through force_law, friction, sensitivity, contact_area (predicted error" in words
    assert "receptors (instead of sensitivity) " in words
    assert "taken for granted: no resistance of body and source" in words
    assert (
        "the level rests on the force law (one of four, which differ by a factor near 1000); the displacement" in words
    )
    record = json.loads(output(capsys, "run", study, "--participant", "P01", "--dry-run", "--json"))
    (felt,) = record["felt"]
    changes = {each["effect"]: each["change_db"] for each in felt["left_out"]}
    assert changes["friction_lag"] < 0
    assert changes["skin_leakage"] < 0
    assert changes["air_gap"] is None


def test_a_simulation_explains_and_replays(study, tmp_path, capsys):
    simulated = ("simulate", study, "--participants", 1, "--seed", 1, "--out", tmp_path / "d", "--explain")
    assert "taken for granted" in output(capsys, *simulated)
    assert "rows agree" in output(capsys, "replay", tmp_path / "d")
    told = "force_law (law = sc_layer), friction, sensitivity, contact_area; accuracy 0.05"
    (journal,) = (tmp_path / "d" / "journals").glob("*.jsonl")
    assert heads(journal)[0].facts["felt"] == told
    output(capsys, "analyse", tmp_path / "d", "--report", tmp_path / "r.html")
    assert f"was felt through these effects: {told}." in (tmp_path / "r.html").read_text(encoding="utf-8")
    default = output(
        capsys, "simulate", "tutorial", "--participants", 1, "--seed", 1, "--out", tmp_path / "e", "--explain"
    )
    assert (
        "through skin_leakage, contact_area, force_law, friction, friction_lag, skin_mobility, sensitivity"
        in " ".join(default.split())
    )


def test_a_check_tells_what_is_felt(study):
    from tactometry.experiments.bench.preflight import _study

    findings, _ = _study(str(study))
    assert [finding.part for finding in findings] == ["study", "scene"]
    assert "felt of amplitude_modulated" in findings[1].found


# --- what is not called for is not imported


def test_effects_that_no_study_calls_for_are_not_imported(study, tmp_path):
    script = (
        "import sys, json; from tactometry.cli import main\n"
        "try: main()\n"
        "finally: print(json.dumps(list(sys.modules)), file=sys.stderr)"
    )
    words = ["simulate", str(study), "--participants", "1", "--seed", "1", "--out", str(tmp_path / "d")]
    result = subprocess.run([sys.executable, "-I", "-c", script, *words], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    modules = set(json.loads(result.stderr.splitlines()[-1]))
    stated = {"force_law", "friction", "sensitivity", "contact_area", "skin_mobility"}  # that by default
    by_kind = {kind: EFFECTS[kind].partition(":")[0] for kind in OF_ELECTROVIBRATION}
    assert {kind for kind, module in by_kind.items() if module in modules} == stated
    assert not {name for name in modules if name.endswith(("motion.finger", "motion.pad", "motion.stick_slip"))}
    assert "tactometry.stimuli.electrovibration.sensation" not in modules


def inline(kind):
    values = {"law": '"sc_layer"'} if kind == "force_law" else CASES[kind][0]
    return "{ " + ", ".join([f'kind = "{kind}"', *(f"{key} = {value}" for key, value in values.items())]) + " }"


SLOTS = {"dry_friction": "friction", "receptors": "sensitivity", "summation": "sensitivity"}


def with_company(kind):
    """An effect, and no more than what it can be felt with."""
    needs = CASES[kind][1] if kind in CASES else ()
    return ({kind, *needs, "force_law", "friction", "sensitivity"} - {SLOTS.get(kind)}) - {"plain"}


PANEL_KINDS = [kind for kind in OF_ELECTROVIBRATION if not resolve(EFFECTS[kind]).in_signal]
PLATE_KINDS = ["finger_load", "focus_detection", "movie", "drive_energy"]
OTHERS = [kind for kind in OF_TIME_REVERSAL if not resolve(EFFECTS[kind]).in_signal]
ALWAYS = {"skin_mobility"}
"""What a panel has by default in its scenes: friction moves the skin."""
UNFELT = {"movie": "focus_detection", "drive_energy": "focus_detection"}


@pytest.fixture(scope="module")
def loaded():
    """What each scene states, and the modules behind a level through it, felt in a process of its own."""
    if not hasattr(os, "fork"):
        pytest.skip("needs os.fork for a process per effect")
    panels = {kind: with_company(kind) for kind in [*PANEL_KINDS, "plain"]}
    plates = {kind: {kind, "focus_detection"} for kind in PLATE_KINDS}
    studies = {kind: scene(*map(inline, sorted(kinds))) for kind, kinds in panels.items()}
    for kind, kinds in plates.items():
        studies[kind] = f"{FOCI}\n[scene]\neffects = [{', '.join(map(inline, sorted(kinds)))}]\n"
    script = ROOT / "tests" / "support" / "felt_processes.py"
    done = subprocess.run(
        [sys.executable, script], input=json.dumps(studies), capture_output=True, text=True, check=True
    )
    return panels | plates, {kind: set(modules) for kind, modules in json.loads(done.stdout).items()}


@pytest.mark.parametrize("kind", [*PANEL_KINDS, *PLATE_KINDS])
def test_a_study_imports_the_effects_that_its_scene_states_and_no_other(loaded, kind):
    stated, modules = loaded
    found = {name for name in (*PANEL_KINDS, *OTHERS) if EFFECTS[name].partition(":")[0] in modules[kind]}
    assert found - ALWAYS == stated[kind] - ALWAYS


@pytest.mark.parametrize("kind", UNFELT)
def test_an_effect_that_nothing_felt_needs_imports_no_more_than_its_name(loaded, kind):
    _, modules = loaded
    named = EFFECTS[kind].partition(":")[0]
    assert {named} <= modules[kind] - modules[UNFELT[kind]] <= {named, named.rpartition(".")[0]}


def test_the_table_of_the_page_is_felt():
    page = (DOCS / "studies.md").read_text("utf-8").partition("## Scenes")[2]
    table = page.partition("```toml\n")[2].partition("```")[0]
    (felt,) = felt_effects(wired(f"{TUTORIAL}\n{table}"))
    assert felt.felt[-2:] == ("receptors", "masking")


# --- foci, and both at once

PLATE = """
[scene]
effects = [{ kind = "finger_load" }, { kind = "focus_detection", reference_m = 8e-6 }]
"""


def of_study(name, more):
    return wired(load(name)[1].decode() + more)


def cell_of(experiment, kind):
    return next(cell for cell in experiment.cells.values() if cell.condition.stimulus.startswith(kind))


@pytest.mark.parametrize("criterion", ["loaded", "unloaded"])
def test_foci_are_felt_through_a_scene_as_through_the_formula_of_its_effects(criterion):
    loads = criterion == "loaded"
    table = PLATE if loads else PLATE.replace('{ kind = "finger_load" }, ', "")
    cell = cell_of(of_study("time-reversal-threshold", table), "focus")
    model = TimeReversalSensation(cell.stimulus.setup, 8e-6, criterion)
    for contact in (Contact(0.5), Contact(3.0)):
        signal = cell.stimulus.at(20.0)
        assert cell.sensation.sensation_db(signal, contact) == pytest.approx(
            time_reversal_formula.level_db(model, signal, contact), abs=1e-12
        )


def test_a_built_in_scene_of_a_plate_takes_that_of_the_stimulus():
    (felt,) = felt_effects(of_study("time-reversal-threshold", '\n[scene]\nname = "a4-screen"\n'))
    assert felt.felt == ("finger_load", "focus_detection")
    assert felt.assumed[0].startswith("plate, patches and losses as the stimulus states them")


def test_a_built_in_scene_of_both_is_felt_on_the_side_that_each_stimulus_is_played_on():
    experiment = of_study("hybrid-button", '\n[scene]\nname = "hybrid-screen"\n')
    felt = {one.stimulus.partition(",")[0]: one.felt for one in felt_effects(experiment)}
    rested = ("finger_load", "focus_detection")
    slid = ("skin_leakage", "contact_area", "force_law", "friction", "friction_lag", "sensitivity")
    assert felt == {"focus": rested, "amplitude_modulated": slid, "hybrid": (*rested, *slid)}


def test_of_both_the_stronger_one_is_felt_and_friction_by_a_finger_that_slides():
    experiment = of_study("hybrid-button", '\n[scene]\nname = "hybrid-screen"\n')
    both, foci = (cell_of(experiment, kind) for kind in ("hybrid", "focus"))
    friction = cell_of(experiment, "amplitude_modulated").sensation.scene
    signal = both.stimulus.at(16.0)
    resting, sliding = (both.sensation.sensation_db(signal, Contact(1.0, speed)) for speed in (0.0, 0.05))
    of_foci = foci.sensation.sensation_db(both.stimulus.focus.at(16.0), Contact(1.0))
    of_friction = friction.sensation(
        both.stimulus.friction.at(16.0 + both.stimulus.electrode_offset_db), Contact(1, 0.05)
    )
    assert resting == pytest.approx(of_foci, abs=1e-6)
    assert sliding == pytest.approx(max(of_foci, of_friction), abs=1e-6)


ON_A_PLATE = {
    "no threshold": ('effects = [{ kind = "finger_load" }]', "add the effect focus_detection"),
    "what the stimulus states": (
        'effects = [{ kind = "shear" }, { kind = "focus_detection" }]',
        "scene.effects[0]: found 'shear', which changes what is played or on what, expected what [stimulus] states",
    ),
    "an effect of the other surface": (
        'effects = [{ kind = "friction" }, { kind = "focus_detection" }]',
        "scene.effects[0]: found 'friction', which 'time_reversal' does not know, expected an effect of ",
    ),
    "a scene on the other surface": (
        'name = "electrovibration-panel"',
        "scene.name: found 'electrovibration-panel', a scene on 'electrovibration', expected one on 'time_reversal', "
        "such as 'a4-screen'",
    ),
    "a scene without a threshold": ('name = "thin-screen"', "add the effect focus_detection"),
    "a finger that lifts off": (
        'effects = [{ kind = "focus_detection" }, { kind = "finger_load" }, { kind = "lift_off" }]',
        "scene.effects: found 'lift_off' where signals are felt, expected the linear contact of 'finger_load'; remove",
    ),
    "a finger beside the plate": (
        'effects = [{ kind = "focus_detection" }]\nsurface = { finger_x_m = 2.0 }',
        "scene.surface.finger_x_m, finger_y_m: found (2.0, ",
    ),
    "a finger of no plate": (
        'effects = [{ kind = "focus_detection" }]\nsurface = { finger_x_m = 1e300 }',
        "scene.surface.finger_x_m: found 1e+300, expected a number of at most 1e+09",
    ),
    "a plate": (
        'effects = [{ kind = "focus_detection" }]\nsurface = { length_m = 0.1 }',
        "scene.surface.length_m: found an unknown key",
    ),
}


@pytest.mark.parametrize("name", ON_A_PLATE)
def test_a_scene_of_a_plate_that_cannot_be_felt_is_refused(name):
    keys, sentence = ON_A_PLATE[name]
    with pytest.raises(InvalidParameter) as refused:
        wired(f"{FOCI}\n[scene]\n{keys}\n")
    assert sentence in str(refused.value)


def test_a_stimulus_that_is_measured_takes_no_scene():
    reading = STIMULI["measured_focus"]
    with pytest.raises(
        InvalidParameter, match="scene: found a table with a stimulus that no scene plays, expected another"
    ):
        felt_scene({"name": "a4-screen"}, reading.surface, None, None)


def test_the_plate_of_the_page_is_felt_loaded_and_not():
    page = (DOCS / "studies.md").read_text("utf-8").partition("On a plate that focuses")[2]
    table = page.partition("```toml\n")[2].partition("```")[0]
    told = felt_effects(of_study("time-reversal-threshold", f"\n{table}"))
    assert [one.felt for one in told] == [("focus_detection",)]
    assert {one.effect: one.change_db for one in told[0].left_out}["finger_load"] < -1


# --- fingers on places


TWO = """
[sensation]
fingers = ["index", "middle"]                   # which places have a finger; each feels the field of all foci there
"""


def on_fingers(scene_table):
    """The study of localisation at one distance, with a scene of its own."""
    text = changed(load("time-reversal-localisation")[1].decode(), {TWO: f"\n{scene_table}\n"})
    text = text.replace("[0.010, 0.013, 0.017, 0.022, 0.028, 0.036, 0.050]", "[0.050]")
    return "\n".join(line for line in text.splitlines() if not line.startswith('"0.0') or '"0.05"' in line)


DETECTED = 'effects = [{ kind = "focus_detection" }]'


def fingers_db(scene_table):
    cell = next(iter(wired(on_fingers(scene_table)).cells.values()))
    return cell.sensation.fingers_db(cell.stimulus.at(12.0), Contact(1.0))


def test_foci_under_fingers_are_felt_through_the_scene_of_the_study():
    default_db = fingers_db(TWO)
    assert fingers_db(f"[scene]\n{DETECTED}") == default_db
    index_db = fingers_db(f'[scene]\nsurface = {{ fingers = ["index"] }}\n{DETECTED}')
    assert index_db == default_db[:1]
    loaded = 'effects = [{ kind = "finger_load" }, { kind = "focus_detection" }]'
    assert all(found < free for found, free in zip(fingers_db(f"[scene]\n{loaded}"), default_db, strict=True))
    assert fingers_db('[scene]\nname = "a4-screen"') == fingers_db(f"[scene]\n{loaded}")


FINGER_SENTENCES = {
    '"index", "index"': "scene.surface.fingers[1]: found 'index' twice, expected each place once: two fingers",
    '"ring"': "scene.surface.fingers: found 'ring', expected one of index, middle",
    "1e300": "scene.surface.fingers[0]: found 1e+300, expected",
    "nan": "scene.surface.fingers[0]: found nan, expected",
}


@pytest.mark.parametrize("fingers", FINGER_SENTENCES)
def test_fingers_of_a_scene_that_rest_nowhere_are_refused(fingers):
    text = on_fingers(f"[scene]\nsurface = {{ fingers = [{fingers}] }}\n{DETECTED}")
    with pytest.raises(InvalidParameter, match=re.escape(FINGER_SENTENCES[fingers])):
        wired(text)


# --- masking, and receptors behind foci


DETECTION = '{ kind = "focus_detection" }'
AT_REST, IN_MOTION = Contact(1.0), Contact(1.0, 0.05)
MASKED = '{ kind = "masking", level_db_re_threshold = 25.0 }'


@pytest.mark.parametrize("pattern", ["P0", "P1", "P6"])
def test_a_masker_raises_the_threshold_of_foci_by_its_rule(pattern):
    text = FOCI.replace('pattern = "P0"', f'pattern = "{pattern}"')
    studies = [wired(f"{text}\n[scene]\neffects = [{of}]\n") for of in (DETECTION, f"{DETECTION}, {MASKED}")]
    signal = next(iter(studies[0].cells.values())).stimulus.at(4.0)
    free_db, masked_db = (study.sensation().sensation_db(signal, AT_REST) for study in studies)
    assert free_db - masked_db == pytest.approx(0.52 * 25.0)


def test_a_masker_raises_the_threshold_at_each_finger():
    free_db = fingers_db(f"[scene]\n{DETECTED}")
    masked_db = fingers_db(f"[scene]\neffects = [{DETECTION}, {MASKED}]")
    assert [free - masked for free, masked in zip(free_db, masked_db, strict=True)] == pytest.approx([13.0, 13.0])


def hybrid_db(*more, contact=IN_MOTION, level=28.0):
    effects = ", ".join([DETECTION, *EFFECT_LINES.values(), *more])
    experiment = of_study("hybrid-button", f"[variants.feedback.both.scene]\neffects = [{effects}]\n")
    cell = cell_of(experiment, "hybrid")
    return cell.sensation.sensation_db(cell.stimulus.at(level), contact)


def test_a_masker_raises_both_thresholds_of_a_hybrid():
    for contact in (AT_REST, IN_MOTION):  # foci alone, then the stronger of both
        assert hybrid_db(contact=contact) - hybrid_db(MASKED, contact=contact) == pytest.approx(13.0)


def test_receptors_feel_the_friction_of_a_hybrid_and_its_foci_are_felt_as_before():
    receptors = [line.replace("sensitivity", "receptors") for line in EFFECT_LINES.values()]
    effects = ", ".join([DETECTION, *receptors])
    cell = cell_of(of_study("hybrid-button", f"[variants.feedback.both.scene]\neffects = [{effects}]\n"), "hybrid")
    signal = cell.stimulus.at(28.0)
    for contact in (AT_REST, IN_MOTION):
        assert cell.sensation.sensation_db(signal, contact) == pytest.approx(hybrid_db(contact=contact), abs=0.05)


def test_foci_beside_friction_mask_each_other_where_a_study_asks_for_it():
    foci_db, both_db = hybrid_db(contact=AT_REST), hybrid_db()
    assert both_db > foci_db > 0  # friction is the stronger one
    foci = '{ kind = "cross_masking", target = "foci" }'
    assert hybrid_db(foci, contact=AT_REST) == pytest.approx(foci_db)  # no friction, no masker
    assert hybrid_db(foci) == pytest.approx(foci_db - 0.52 * both_db)
    friction = '{ kind = "cross_masking", target = "friction", slope = 0.25 }'
    assert hybrid_db(friction) == pytest.approx(both_db - 0.25 * foci_db)
    faint_db = hybrid_db(foci, level=-20.0)  # below its threshold a masker does not mask
    assert faint_db == pytest.approx(hybrid_db(contact=AT_REST, level=-20.0))


REFUSED = {
    DETECTION + ', { kind = "receptors" }': "scene.effects[1]: found 'receptors' on 'time_reversal', expected "
    "'focus_detection' in its place: a focus is felt as one event, whose spectrum in the skin no source states",
    '{ kind = "summation" }': "scene.effects[0]: found 'summation' on 'time_reversal', expected 'focus_detection'",
    DETECTION
    + ', { kind = "cross_masking", target = "foci" }': "found 'cross_masking', which 'time_reversal' does not",
    DETECTION + ', { kind = "masking", level_db_re_threshold = nan }': "level_db_re_threshold: found nan, expected",
    DETECTION + ', { kind = "masking", level_db_re_threshold = "loud" }': "level_db_re_threshold: found 'loud'",
    DETECTION + ', { kind = "masking" }': "effects[1].level_db_re_threshold: found no such key, expected a number",
}


@pytest.mark.parametrize("effects", REFUSED)
def test_effects_that_foci_are_not_felt_by_are_refused_with_their_cure(effects):
    with pytest.raises(InvalidParameter) as refusal:
        wired(f"{FOCI}\n[scene]\neffects = [{effects}]\n")
    assert REFUSED[effects] in str(refusal.value)


def test_a_target_that_is_none_is_refused():
    with pytest.raises(InvalidParameter, match="target: found 'thumb', expected one of foci, friction"):
        hybrid_db('{ kind = "cross_masking", target = "thumb" }')


def test_the_journal_of_a_session_with_fingers_says_what_they_felt():
    """Scenes of the fingers have fields that only the stimulus states."""
    from tactometry.experiments.study.felt_words import scene_in_words

    felt = next(iter(wired(on_fingers(TWO)).cells.values())).sensation
    assert scene_in_words(felt.scene) == "focus_detection; fingers = index and middle; accuracy 0.02"


def test_what_fingers_take_for_granted_is_told_as_their_scene_has_it():
    (free,) = felt_effects(wired(on_fingers(TWO)))
    said = "fingers that do not damp what others feel", "fingers that share the force of a touch evenly"
    assert set(said) <= set(free.assumed)
    assert "at rest: 0.0 dB above threshold" in " ".join(free.lines)  # not -0.0
    loaded = 'effects = [{ kind = "finger_load" }, { kind = "focus_detection" }]'
    (bearing,) = felt_effects(wired(on_fingers(f"[scene]\n{loaded}")))
    assert said[0] not in bearing.assumed
    assert said[1] in bearing.assumed
