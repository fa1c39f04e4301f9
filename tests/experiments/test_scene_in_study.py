"""`[scene]` in studies of a panel: sensation, output and refusals."""

import json

import electrovibration_formula
import hybrid_formula
import pytest
import time_reversal_formula
from command_line import call, output
from places import DOCS, ROOT
from scene_studies import EFFECT_LINES, SHORT, TUTORIAL, scene
from study_texts import changed, wired

from tactometry.config.strict import build
from tactometry.contact import Contact
from tactometry.experiments.study.felt_effects import felt_effects
from tactometry.experiments.study.felt_scene import FeltScene
from tactometry.experiments.study.kinds import STIMULI
from tactometry.experiments.study.study_file import builtin, load
from tactometry.loading import resolve
from tactometry.records.head import heads


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
    """Build the sensation model of a cell from `[sensation]`."""
    kind = STIMULI[cell.condition.stimulus.partition(",")[0]]
    shared = {name: getattr(cell.stimulus, name) for name in kind.shared}
    return build(resolve(kind.sensation), numbers, "sensation", **shared)


@pytest.mark.parametrize("study", builtin())
def test_built_in_scene_equals_the_formula(study):
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
def test_sensation_keys_equal_formula_and_effects(name):
    keys, kind = SENSATIONS[name]
    study = wired(f"{TUTORIAL}\n[sensation]\n{keys}\n")
    cell, plain, stated = next(iter(study.cells.values())), wired(TUTORIAL).sensation(), study.sensation()
    signal, model = cell.stimulus.at(30.0), model_of(cell, **study.study.sensation)
    for contact in CONTACTS[1:]:
        level_db = stated.sensation_db(signal, contact)
        assert level_db == pytest.approx(electrovibration_formula.level_db(model, signal, contact), abs=1e-12)
        assert level_db != plain.sensation_db(signal, contact)
    assert not kind or kind in {effect.kind for effect in stated.scene.effects}


def test_default_scene_lists_its_effects():
    (felt,) = felt_effects(wired(TUTORIAL))
    assert felt.felt == (*LEAKY, "skin_mobility", "sensitivity")


def test_imperceptible_at_rest_is_stated():
    at_rest = TUTORIAL.replace('kind = "slide"', 'kind = "press"').replace('speed_m_per_s = "50 mm/s"\n', "")
    (told,) = felt_effects(wired(at_rest))
    text = " ".join(" ".join(told.lines).split())
    assert "1 N, at rest: not felt by a resting finger, computed with the effects skin_leakage" in text
    assert "weber_fraction (not felt with it either)" in text
    assert "inf" not in text
    (sliding,) = felt_effects(wired(TUTORIAL))
    assert not sliding.finger_rests


def test_each_effect_of_a_scene_is_felt():
    plain_db = felt_db(scene())
    masked_db = felt_db(scene(*EFFECT_LINES.values(), '{ kind = "masking", level_db_re_threshold = 25.0 }'))
    assert plain_db - masked_db == pytest.approx(0.52 * 25)
    other = [EFFECT_LINES["force_law"], EFFECT_LINES["sensitivity"], '{ kind = "friction", coefficient = 1.0 }']
    assert felt_db(scene(*other)) - plain_db == pytest.approx(6.0206, abs=1e-3)


def test_scene_file_equals_its_tables(tmp_path):
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


def test_thicker_insulator_is_felt_less():
    assert felt_db(scene(surface='{ insulator_thickness_m = "2 um" }')) < felt_db(scene())


def test_variant_of_factor_changes_scene():
    text = scene() + "\n[variants.frequency_hz.240.scene]\naccuracy = 0.5\n"
    accuracies = [cell.sensation.scene.accuracy for cell in wired(text).cells.values()]
    assert accuracies == [0.05, 0.5]
    assert len(felt_effects(wired(text))) == 2


SENTENCES = [
    (scene(acuracy=0.1), "scene.acuracy: found an unknown key"),
    (scene('{ kind = "frictoin" }'), "scene.effects[0].kind: found 'frictoin', expected one of "),
    (scene('{ kind = "one_bit" }'), "scene.effects[0]: found 'one_bit', which 'electrovibration' does not support"),
    (scene(*EFFECT_LINES.values(), '{ kind = "receptors" }'), "scene.effects[2]: found 'sensitivity' with"),
    (
        scene('{ kind = "masking", level_db_re_threshold = 25.0 }', *list(EFFECT_LINES.values())[:2]),
        "scene: outputs: found no stage or effect for 'sensation_db'",
    ),
    (scene(*list(EFFECT_LINES.values())[:2]), "scene: outputs: found no stage or effect for 'sensation_db'"),
    (scene(*list(EFFECT_LINES.values())[1:]), "add the effect force_law and name one of the four laws"),
    (scene(accuracy=0.0), "scene.accuracy: found 0.0, expected a number above 0 and at most 1"),
    (scene(accuracy=1e-12), "loosen the accuracy"),
    (scene('{ kind = "carrier" }'), "scene.effects[0]: found 'carrier', which changes the played signal, expected"),
    (scene(surface="{ frequency_hz = 60 }"), "scene.surface.frequency_hz: found a key of [stimulus], expected it only"),
    (
        scene(surface='{ kind = "time_reversal" }'),
        "scene.surface.kind: found 'time_reversal', expected 'electrovibration', the surface of the stimulus; use "
        "[variants.FACTOR.LEVEL.scene] if levels of a factor have different surfaces",
    ),
    (
        named("electrovibration-panle"),
        "scene.name: found 'electrovibration-panle', expected a path or one of a4-screen, electrovibration-panel, "
        "hybrid-screen, thin-screen; did you mean 'electrovibration-panel'?",
    ),
    (named(ROOT / "pyproject.toml"), "pyproject.toml, build-system: found an unknown key"),
    (named("a4-screen"), "scene.name: found 'a4-screen', a scene on 'time_reversal', expected a scene on"),
    (
        named("electrovibration-panel", "effects = []\nsurface = { area_m2 = 1e-4 }\n"),
        "scene.name: found 'electrovibration-panel' next to surface or effects, expected one of the two",
    ),
    (scene() + "[sensation]\nreference_force_n = 1e-5\n", "sensation: found a table next to [scene], expected only"),
    (
        changed(scene(), {'kind = "slide"': 'kind = "press"', 'speed_m_per_s = "50 mm/s"\n': ""}),
        "touch.kind: found 'press' with a [scene], expected 'slide'",
    ),
]


@pytest.mark.parametrize(("text", "sentence"), SENTENCES, ids=[sentence for _, sentence in SENTENCES])
def test_imperceptible_scene_is_refused_before_playing(text, sentence, tmp_path, capsys):
    path = tmp_path / "s.toml"
    path.write_text(text, encoding="utf-8")
    code, said, _ = call(capsys, "simulate", path, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert code == 2
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


def test_dry_run_lists_felt_and_omitted_effects(study, capsys):
    said = output(capsys, "run", study, "--participant", "P01", "--dry-run")
    words = " ".join(said.split())
    assert "effects force_law, friction, sensitivity, contact_area (predicted error" in words
    assert "receptors (instead of sensitivity) " in words
    assert "assumptions: no resistance of body and source" in words
    assert "the prediction depends on the force law (one of four, which differ by a factor near 1000); the" in words
    record = json.loads(output(capsys, "run", study, "--participant", "P01", "--dry-run", "--json"))
    (felt,) = record["felt"]
    changes = {each["effect"]: each["change_db"] for each in felt["left_out"]}
    assert max(changes["friction_lag"], changes["skin_leakage"]) < 0
    assert changes["air_gap"] is None


def test_simulation_with_scene_explains_and_replays(study, tmp_path, capsys):
    simulated = ("simulate", study, "--participants", 1, "--seed", 1, "--out", tmp_path / "d", "--explain")
    assert "assumptions: " in output(capsys, *simulated)
    assert "rows agree" in output(capsys, "replay", tmp_path / "d")
    told = "force_law (law = sc_layer), friction, sensitivity, contact_area; accuracy 0.05"
    (journal,) = (tmp_path / "d" / "journals").glob("*.jsonl")
    assert heads(journal)[0].facts["felt"] == told
    output(capsys, "analyse", tmp_path / "d", "--report", tmp_path / "r.html")
    assert f"were perceived through these effects: {told}." in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_check_reports_felt_effects(study):
    from tactometry.experiments.bench.preflight import _study

    findings, _ = _study(str(study), allow_code=False)
    assert [finding.part for finding in findings] == ["study", "study", "scene"]
    assert findings[1].what == "not felt"
    assert "predicted for amplitude_modulated" in findings[2].found


def test_documented_scene_table_is_felt():
    page = (DOCS / "reference" / "studies.md").read_text("utf-8").partition("## Scenes")[2]
    table = page.partition("```toml\n")[2].partition("```")[0]
    (felt,) = felt_effects(wired(f"{TUTORIAL}\n{table}"))
    assert felt.felt[-2:] == ("receptors", "masking")
