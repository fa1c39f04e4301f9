"""`[scene]` in studies of foci, on fingers and with friction."""

import pytest
import time_reversal_formula
from places import DOCS
from scene_studies import EFFECT_LINES, FOCI
from study_texts import changed, refusal, wired

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.felt_effects import felt_effects
from tactometry.experiments.study.felt_scene import felt_scene, scene_in_words
from tactometry.experiments.study.kinds import STIMULI
from tactometry.experiments.study.study_file import load
from tactometry.stimuli.time_reversal.stimulus.sensation import TimeReversalSensation

PLATE = """
[scene]
effects = [{ kind = "finger_load" }, { kind = "focus_detection", reference_m = 8e-6 }]
"""


def of_study(name, more):
    return wired(load(name)[1].decode() + more)


def cell_of(experiment, kind):
    return next(cell for cell in experiment.cells.values() if cell.condition.stimulus.startswith(kind))


@pytest.mark.parametrize("criterion", ["loaded", "unloaded"])
def test_scene_of_foci_equals_the_formula(criterion):
    loads = criterion == "loaded"
    table = PLATE if loads else PLATE.replace('{ kind = "finger_load" }, ', "")
    cell = cell_of(of_study("time-reversal-threshold", table), "focus")
    model = TimeReversalSensation(cell.stimulus.setup, 8e-6, criterion)
    for contact in (Contact(0.5), Contact(3.0)):
        signal = cell.stimulus.at(20.0)
        assert cell.sensation.sensation_db(signal, contact) == pytest.approx(
            time_reversal_formula.level_db(model, signal, contact), abs=1e-12
        )


def test_built_in_plate_scene_uses_the_stimulus_plate():
    (felt,) = felt_effects(of_study("time-reversal-threshold", '\n[scene]\nname = "a4-screen"\n'))
    assert felt.felt == ("finger_load", "focus_detection")
    assert felt.assumed[0].startswith("plate, patches and losses as the stimulus states them")


def test_hybrid_scene_is_felt_on_the_played_side():
    experiment = of_study("hybrid-button", '\n[scene]\nname = "hybrid-screen"\n')
    felt = {one.stimulus.partition(",")[0]: one.felt for one in felt_effects(experiment)}
    rested = ("finger_load", "focus_detection")
    slid = ("skin_leakage", "contact_area", "force_law", "friction", "friction_lag", "sensitivity")
    assert felt == {"focus": rested, "amplitude_modulated": slid, "hybrid": (*rested, *slid)}


def test_hybrid_scene_takes_the_stronger_side():
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


DETECTED = 'effects = [{ kind = "focus_detection" }]'
DETECTION = '{ kind = "focus_detection" }'
REFUSED = [
    ('effects = [{ kind = "finger_load" }]', "add the effect focus_detection"),
    ('name = "thin-screen"', "add the effect focus_detection"),
    (f'effects = [{{ kind = "shear" }}, {DETECTION}]', "scene.effects[0]: found 'shear', which changes the played"),
    (f'effects = [{{ kind = "friction" }}, {DETECTION}]', "scene.effects[0]: found 'friction', which 'time_reversal'"),
    ('name = "electrovibration-panel"', "scene.name: found 'electrovibration-panel', a scene on 'electrovibration'"),
    (
        f'effects = [{DETECTION}, {{ kind = "finger_load" }}, {{ kind = "lift_off" }}]',
        "scene.effects: found 'lift_off' where signals are felt, expected the linear contact of 'finger_load'; remove",
    ),
    (f"{DETECTED}\nsurface = {{ finger_x_m = 2.0 }}", "scene.surface.finger_x_m, finger_y_m: found (2.0, "),
    (f"{DETECTED}\nsurface = {{ finger_x_m = 1e300 }}", "scene.surface.finger_x_m: found 1e+300, expected a number of"),
    (f"{DETECTED}\nsurface = {{ length_m = 0.1 }}", "scene.surface.length_m: found an unknown key"),
    (f'effects = [{DETECTION}, {{ kind = "receptors" }}]', "scene.effects[1]: found 'receptors' on 'time_reversal'"),
    ('effects = [{ kind = "summation" }]', "scene.effects[0]: found 'summation' on 'time_reversal', expected 'focus_"),
    (f'effects = [{DETECTION}, {{ kind = "cross_masking", target = "foci" }}]', "found 'cross_masking', which"),
    (f'effects = [{DETECTION}, {{ kind = "masking", level_db_re_threshold = nan }}]', "found nan, expected"),
    (f'effects = [{DETECTION}, {{ kind = "masking", level_db_re_threshold = "loud" }}]', "found 'loud', expected"),
    (f'effects = [{DETECTION}, {{ kind = "masking" }}]', "effects[1].level_db_re_threshold: found no such key"),
]


@pytest.mark.parametrize(("keys", "sentence"), REFUSED)
def test_imperceptible_plate_scene_is_refused(keys, sentence):
    assert sentence in refusal(f"{FOCI}\n[scene]\n{keys}\n")


def test_measured_stimulus_takes_no_scene():
    reading = STIMULI["measured_focus"]
    with pytest.raises(
        InvalidParameter, match="scene: found a table with a stimulus that no scene supports, expected another"
    ):
        felt_scene({"name": "a4-screen"}, reading.surface, None, None)


def test_documented_plate_is_felt_with_and_without_load():
    page = (DOCS / "reference" / "studies.md").read_text("utf-8").partition("On a plate that focuses")[2]
    table = page.partition("```toml\n")[2].partition("```")[0]
    told = felt_effects(of_study("time-reversal-threshold", f"\n{table}"))
    assert [one.felt for one in told] == [("focus_detection",)]
    assert {one.effect: one.change_db for one in told[0].left_out}["finger_load"] < -1


# --- fingers on places


TWO = """
[sensation]
fingers = ["index", "middle"]                   # places with a finger; each feels the sum of all foci
"""


def on_fingers(scene_table):
    text = changed(load("time-reversal-localisation")[1].decode(), {TWO: f"\n{scene_table}\n"})
    text = text.replace("[0.010, 0.013, 0.017, 0.022, 0.028, 0.036, 0.050]", "[0.050]")
    return "\n".join(line for line in text.splitlines() if not line.startswith('"0.0') or '"0.05"' in line)


def fingers_db(scene_table):
    cell = next(iter(wired(on_fingers(scene_table)).cells.values()))
    return cell.sensation.fingers_db(cell.stimulus.at(12.0), Contact(1.0))


def test_foci_under_fingers_use_study_scene():
    default_db = fingers_db(TWO)
    assert fingers_db(f"[scene]\n{DETECTED}") == default_db
    index_db = fingers_db(f'[scene]\nsurface = {{ fingers = ["index"] }}\n{DETECTED}')
    assert index_db == default_db[:1]
    loaded = 'effects = [{ kind = "finger_load" }, { kind = "focus_detection" }]'
    assert all(found < free for found, free in zip(fingers_db(f"[scene]\n{loaded}"), default_db, strict=True))
    assert fingers_db('[scene]\nname = "a4-screen"') == fingers_db(f"[scene]\n{loaded}")


FINGER_SENTENCES = {
    '"index", "index"': "found 'index' twice, expected each place once, as two fingers",
    '"ring"': "scene.surface.fingers: found 'ring', expected one of index, middle",
    "1e300": "scene.surface.fingers[0]: found 1e+300, expected",
    "nan": "scene.surface.fingers[0]: found nan, expected",
}


@pytest.mark.parametrize("fingers", FINGER_SENTENCES)
def test_scene_fingers_without_place_are_refused(fingers):
    text = on_fingers(f"[scene]\nsurface = {{ fingers = [{fingers}] }}\n{DETECTED}")
    assert FINGER_SENTENCES[fingers] in refusal(text)


# --- masking, and receptors behind foci


AT_REST, IN_MOTION = Contact(1.0), Contact(1.0, 0.05)
MASKED = '{ kind = "masking", level_db_re_threshold = 25.0 }'


@pytest.mark.parametrize("pattern", ["P0", "P1", "P6"])
def test_masker_raises_focus_threshold_by_rule(pattern):
    text = FOCI.replace('pattern = "P0"', f'pattern = "{pattern}"')
    studies = [wired(f"{text}\n[scene]\neffects = [{of}]\n") for of in (DETECTION, f"{DETECTION}, {MASKED}")]
    signal = next(iter(studies[0].cells.values())).stimulus.at(4.0)
    free_db, masked_db = (study.sensation().sensation_db(signal, AT_REST) for study in studies)
    assert free_db - masked_db == pytest.approx(0.52 * 25.0)


def test_masker_raises_threshold_at_each_finger():
    free_db = fingers_db(f"[scene]\n{DETECTED}")
    masked_db = fingers_db(f"[scene]\neffects = [{DETECTION}, {MASKED}]")
    assert [free - masked for free, masked in zip(free_db, masked_db, strict=True)] == pytest.approx([13.0, 13.0])


def hybrid_db(*more, contact=IN_MOTION, level=28.0):
    effects = ", ".join([DETECTION, *EFFECT_LINES.values(), *more])
    experiment = of_study("hybrid-button", f"[variants.feedback.both.scene]\neffects = [{effects}]\n")
    cell = cell_of(experiment, "hybrid")
    return cell.sensation.sensation_db(cell.stimulus.at(level), contact)


def test_masker_raises_both_hybrid_thresholds():
    for contact in (AT_REST, IN_MOTION):  # foci alone, then the stronger of both
        assert hybrid_db(contact=contact) - hybrid_db(MASKED, contact=contact) == pytest.approx(13.0)


def test_receptors_affect_only_friction_of_a_hybrid():
    receptors = [line.replace("sensitivity", "receptors") for line in EFFECT_LINES.values()]
    effects = ", ".join([DETECTION, *receptors])
    cell = cell_of(of_study("hybrid-button", f"[variants.feedback.both.scene]\neffects = [{effects}]\n"), "hybrid")
    signal = cell.stimulus.at(28.0)
    for contact in (AT_REST, IN_MOTION):
        assert cell.sensation.sensation_db(signal, contact) == pytest.approx(hybrid_db(contact=contact), abs=0.05)


def test_foci_and_friction_mask_each_other_if_stated():
    foci_db, both_db = hybrid_db(contact=AT_REST), hybrid_db()
    assert both_db > foci_db > 0  # friction is the stronger one
    foci = '{ kind = "cross_masking", target = "foci" }'
    assert hybrid_db(foci, contact=AT_REST) == pytest.approx(foci_db)  # no friction, no masker
    assert hybrid_db(foci) == pytest.approx(foci_db - 0.52 * both_db)
    friction = '{ kind = "cross_masking", target = "friction", slope = 0.25 }'
    assert hybrid_db(friction) == pytest.approx(both_db - 0.25 * foci_db)
    faint_db = hybrid_db(foci, level=-20.0)  # below its threshold a masker does not mask
    assert faint_db == pytest.approx(hybrid_db(contact=AT_REST, level=-20.0))


def test_unknown_target_is_refused():
    with pytest.raises(InvalidParameter, match="target: found 'thumb', expected one of foci, friction"):
        hybrid_db('{ kind = "cross_masking", target = "thumb" }')


def test_journal_states_effects_felt_by_fingers():
    """Scenes of the fingers have fields that only the stimulus states."""
    felt = next(iter(wired(on_fingers(TWO)).cells.values())).sensation
    assert scene_in_words(felt.scene) == "focus_detection; fingers = index and middle; accuracy 0.02"


def test_assumptions_of_fingers_follow_their_scene():
    (free,) = felt_effects(wired(on_fingers(TWO)))
    said = "fingers that do not damp the motion under other fingers", "fingers that share the force of a touch evenly"
    assert set(said) <= set(free.assumed)
    assert "at rest: 0.0 dB above threshold" in " ".join(" ".join(free.lines).split())  # not -0.0
    loaded = 'effects = [{ kind = "finger_load" }, { kind = "focus_detection" }]'
    (bearing,) = felt_effects(wired(on_fingers(f"[scene]\n{loaded}")))
    assert said[0] not in bearing.assumed
    assert said[1] in bearing.assumed
