"""Scene files and the scene command: key paths, plan and figures."""

import json
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from command_line import status
from places import DOCS

from tactometry.cli.output import say, subcommand
from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.experiments.scenes import names, path_of
from tactometry.loading import resolve
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.explain import explanation, pulled_by
from tactometry.stimuli.scenes.file import load_scene, scene_of
from tactometry.stimuli.scenes.plan import Plan, compute

TONE = {"kind": "electrovibration", "frequency_hz": 60.0, "duration_s": 0.05, "ramp_s": 0.01}
LAW = {"kind": "force_law", "law": "sc_layer"}


def table(**changes):
    return {"outputs": ["t_s", "electrostatic_force_n"], "surface": TONE, "effects": [LAW], **changes}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"accurcy": 0.1}, r"accurcy: found an unknown key, .*did you mean 'accuracy'\?"),
        ({"accuracy": "fine"}, r"accuracy: found 'fine', expected a number"),
        ({"accuracy": 2.0}, r"^accuracy: found 2\.0, expected a number above 0 and at most 1"),
        ({"surface": {**TONE, "kind": "electrovibraton"}}, r"surface\.kind: found .*did you mean 'electrovibration'"),
        ({"surface": {"kind": "electrovibration"}}, r"surface\.frequency_hz: found no such key"),
        ({"surface": {**TONE, "frequency_hz": "60 m"}}, r"surface\.frequency_hz: found '60 m', expected .* Hz"),
        ({"effects": [LAW, {"kind": "skin_leekage"}]}, r"effects\[1\]\.kind: .*did you mean 'skin_leakage'"),
        ({"effects": [{"law": "sc_layer"}]}, r"effects\[0\]\.kind: found no such key, expected"),
        ({"effects": [{**LAW, "law": "sc_laver"}]}, r"effects\[0\]\.law: found 'sc_laver', expected one of"),
        ({"effects": [{**LAW, "x": 1}]}, r"effects\[0\]\.x: found an unknown key"),
        ({"effects": [{"kind": "shear", "factor": 0.8}]}, r"effects\[0\]\.factor: found an unknown key.* shear_factor"),
        ({"effects": [LAW, {"kind": "air_gap", "gap_m": -1.0}]}, r"effects\[1\]\.gap_m: found -1\.0"),
        ({"effects": [LAW, {"kind": "dc_offset", "ratio": 1e300}]}, r"effects\[1\]\.ratio: found 1e\+300, .* 1e\+06"),
        ({"contacts": [{"force_n": 0.0}]}, r"contacts\[0\]\.force_n: found 0\.0, .* omit the contact"),
        ({"contacts": [{"force": 1.0}]}, r"contacts\[0\]\.force: found an unknown key"),
        ({"given": {"level": 1.0}}, r"given\.level: found an unknown quantity, expected one of level_db_re_1v"),
        ({"outputs": []}, r"^outputs: found none"),
    ],
)
def test_invalid_file_is_refused_with_key_path(changes, message):
    with pytest.raises(InvalidParameter, match=message) as refused:
        scene_of(table(**changes))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"sampling": {"n_samples": 0}}, r"sampling\.n_samples: found 0, expected a whole number above 0, such as \d+"),
        ({"sampling": {"n_samples": 33.5}}, r"sampling\.n_samples: found 33\.5, expected a whole number above 0"),
        ({"sampling": {"n_samples": "many"}}, r"sampling\.n_samples: found 'many', expected a whole number"),
        ({"sampling": {"n_sample": 33}}, r"sampling\.n_sample: .*did you mean 'n_samples'"),
        ({"samplin": {}}, r"samplin: .*did you mean 'sampling'"),
    ],
)
def test_invalid_setting_in_file_is_refused(settings, message):
    with pytest.raises(InvalidParameter, match=rf"settings\.{message}"):
        scene_of(table(settings=settings)).scene.resolve()


def test_setting_in_file_overrides_the_chosen_one():
    ours = scene_of(table(settings={"sampling": {"n_samples": 33}}))
    assert ours.scene.resolve().run({"level_db_re_1v": 40.0})["t_s"].size == 33


def test_custom_setting_hides_predicted_error(capsys, tmp_path):
    page = (DOCS / "reference" / "scenes.md").read_text("utf-8")
    (tmp_path / "s.toml").write_text(page.partition("```toml\n")[2].partition("```")[0])
    assert status("scene", tmp_path / "s.toml") == 0
    assert "predicted error not known (a setting is given)" in capsys.readouterr().out


def test_settings_beyond_memory_are_refused():
    huge = scene_of(table(settings={"sampling": {"n_samples": 10**15}}, given={"level_db_re_1v": 40.0}))
    with pytest.raises(
        InvalidParameter, match=r"^scene: found more data than fit into memory .*; loosen the accuracy or"
    ):
        compute(huge.scene.resolve(), huge.given)


def test_movie_without_plate_is_refused(capsys):
    assert status("scene", "electrovibration-panel", "--movie", "a.gif") == 2
    assert "--movie: found a scene on 'electrovibration', which has no wave" in capsys.readouterr().err


@pytest.mark.parametrize("level", [float("nan"), float("inf")])
def test_given_values_must_be_finite(level):
    found = scene_of(table(given={"level_db_re_1v": level}))
    with pytest.raises(InvalidParameter, match=r"given\.level_db_re_1v: found (nan|inf), expected a finite number"):
        found.scene.resolve().run(found.given)


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("level_db_re_1v", r"^outputs\[1\]: found 'level_db_re_1v', an input of each run, .*; remove it"),
        ("skin", r"^outputs\[1\]: found 'skin', an internal quantity, .*; remove it"),
    ],
)
def test_given_and_non_numeric_quantities_are_refused_outputs(output, message):
    with pytest.raises(InvalidParameter, match=message):
        scene_of(table(outputs=["t_s", output])).scene.resolve()


def test_an_unknown_output_names_the_known_ones():
    scene = scene_of(table(outputs=["electrostatic_force"])).scene
    with pytest.raises(
        InvalidParameter,
        match=r"^outputs: found no stage or effect for 'electrostatic_force', .*did you mean '",
    ):
        scene.resolve()


@pytest.mark.parametrize(
    ("outputs", "effect", "place"),
    [("t_s", "skin_leekage", "effects[0].kind"), ("nonsense_n", "skin_leakage", "outputs")],
)
def test_command_names_the_faulty_file(tmp_path, capsys, outputs, effect, place):
    file = tmp_path / "own.toml"
    file.write_text(
        f'outputs = ["{outputs}"]\n[surface]\nkind = "electrovibration"\nfrequency_hz = 60.0\n'
        f'[[effects]]\nkind = "{effect}"\n',
        encoding="utf-8",
    )
    for explain in ([], ["--explain"]):
        assert status("scene", file, *explain) == 2
        assert capsys.readouterr().err.startswith(f"tactometry: {file}, {place}: found")


def test_modulator_overload_is_reported_as_file_error(tmp_path, capsys):
    screen = (
        "kind = 'time_reversal'\nn_transducers = 2\nf_max_hz = 5e3\nflank_hz = 500\nrate_hz = 2e4\nreversal_s = 1e-3"
    )
    file = tmp_path / "own.toml"
    file.write_text(
        f"outputs = ['peak_m']\ngiven = {{ voltage_v = 30.0 }}\n[[effects]]\nkind = 'attenuation'\n"
        f"[[effects]]\nkind = 'sigma_delta'\nscale = 1e9\n[surface]\n{screen}\n",
        encoding="utf-8",
    )
    for more in ([], ["--explain"], ["--cache", tmp_path / "kept"]):
        assert status("scene", file, *more) == 2
        assert capsys.readouterr().err.startswith(f"tactometry: {file}, SigmaDelta(")


def test_invalid_or_absent_file_is_refused(tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text("outputs = [", encoding="utf-8")
    with pytest.raises(InvalidFile, match=r"found no valid TOML"):
        load_scene(bad)
    with pytest.raises(InvalidFile, match=r"cannot be read"):
        load_scene(tmp_path / "absent.toml")
    assert status("scene", "electrovibration-panell") == 2


def roughly(name):
    found = load_scene(path_of(name))
    return replace(found, scene=replace(found.scene, accuracy=0.1))


@pytest.mark.parametrize("name", names())
def test_built_in_scene_runs_with_units_and_provenance(name):
    found = roughly(name)
    result = compute(found.scene.resolve(), found.given)
    assert set(result.values) == set(found.scene.outputs)
    assert result.plan.error <= found.scene.accuracy
    assert result.versions["numpy"]
    for output in result.values:
        assert result.unit(output) or output in {"movie"}


@pytest.mark.parametrize("name", names())
def test_explanation_is_aligned_within_100_columns(name):
    found = roughly(name)
    lines = explanation(found.scene, found.given).splitlines()
    assert max(map(len, lines)) <= 100
    rule = lines.index("-" * 100)
    rows = [line for line in lines[rule + 1 : -3] if not line.startswith("    ")]
    assert {row[24:26] for row in rows} == {"  "}
    assert {row[26:30].strip() for row in rows} == {"on", "off"}
    on = [row.split()[0] for row in rows if row[26:30].strip() == "on"]
    assert on == [stage.name for stage in found.scene.resolve().stages]
    assert lines[-2].startswith(f"accuracy {found.scene.accuracy:g}: predicted error")
    assert lines[-1].startswith("one more digit")


def test_explanation_starts_with_assumptions():
    found = load_scene(path_of("a4-screen"))
    given = replace(found.scene, outputs=("peak_m",))
    said = " ".join(explanation(given, found.given).partition("\nStage")[0].split())
    assert said.startswith("assumptions: edges simply supported all around; a thin plate, without shear")
    assert "patches have neither mass nor stiffness" in said
    assert "it pulls as well as it presses" in said
    assert "transducers that are point forces" not in said  # 'patches' takes its place
    assert "losses" not in said  # there are some
    assert "radiated" not in said  # sound is not asked for
    bare = replace(given, effects=())
    assert "transducers that are point forces" in " ".join(bare.assumed())
    assert "a plate without losses" in bare.assumed()


@pytest.mark.parametrize("kind", EFFECTS)
def test_every_effect_states_its_assumptions(kind):
    effect = resolve(EFFECTS[kind])
    assert isinstance(effect.assumes, tuple)
    assert all(words and words == words.strip(" .;") for words in effect.assumes)
    assert effect.rests_on == effect.rests_on.strip(" .;")


def test_level_is_printed_with_its_calibration_constant(capsys):
    """Outputs that do not use the constant do not print it."""
    from command_line import output

    said = output(capsys, "scene", "a4-screen")
    assert "absolute levels rest on the moment per volt of a patch (calibrated: " in said
    found = load_scene(path_of("a4-screen"))
    explained = " ".join(explanation(replace(found.scene, outputs=("peak_m",)), found.given).split())
    assert "absolute levels rest on the moment per volt of a patch" in explained
    assert "single focus at threshold" not in explained
    assert replace(found.scene, effects=(), outputs=("peak_m",), contacts=()).rests_on() == ()


def test_slow_scene_announces_its_duration(capsys, monkeypatch):
    from command_line import call

    assert "this takes about" not in call(capsys, "scene", "electrovibration-panel")[1]
    monkeypatch.setattr("tactometry.cli.scene.LONG_S", 0.01)
    code, said, out = call(capsys, "scene", "electrovibration-panel")
    assert code == 0
    assert said.startswith("this takes about 0 s, mostly for '")
    assert out.startswith("Electrovibration panel")


@pytest.mark.parametrize(("boundary", "times"), [("FFFF", 1.0), ("CFFF", 2.0)])
def test_predicted_time_includes_ritz_modes(boundary, times):
    """A plan predicted 0.06 s for edges that took 11 s or more."""
    scene = load_scene(path_of("a4-screen")).scene
    effects = (resolve(EFFECTS["attenuation"])(3.5e-3), resolve(EFFECTS["edges"])(boundary))
    plan = replace(scene, effects=effects, outputs=("peak_m",), contacts=(), accuracy=0.2).resolve()
    assert plan.predicted_s == pytest.approx(12 * times, rel=0.3)


def test_amplitudes_scale_with_their_calibration_constant():
    scene = replace(load_scene(path_of("a4-screen")).scene, outputs=("peak_m",), accuracy=0.1)
    patches = next(effect for effect in scene.effects if effect.kind == "patches")
    others = tuple(effect for effect in scene.effects if effect is not patches)
    twice = replace(patches, moment_n_per_v=2 * patches.moment_n_per_v)
    plans = (replace(scene, effects=(*others, moved)).resolve() for moved in (patches, twice))
    once_m, twice_m = (plan.run({"voltage_v": 30.0})["peak_m"] for plan in plans)
    assert twice_m == pytest.approx(2 * once_m, rel=1e-12)


def test_lift_off_is_reported_when_linear_contact_pulls(tmp_path, capsys):
    plate = '[surface]\nkind = "time_reversal"\nlength_m = 0.12\nwidth_m = 0.09\nn_transducers = 8\nfocus_x_m = 0.05\n'
    plate += "focus_y_m = 0.04\nf_max_hz = 15e3\nflank_hz = 3e3\nrate_hz = 60e3\nreversal_s = 3e-3\nafter_s = 1e-3\n"
    rest = '[[effects]]\nkind = "one_bit"\n[[effects]]\nkind = "finger_load"\n[given]\nvoltage_v = 30.0\n'
    pulled = {}
    for force_n in (0.01, 20.0):
        file = tmp_path / f"{force_n}.toml"
        contact = f"[[contacts]]\nforce_n = {force_n}\n"
        file.write_text(f'accuracy = 0.1\noutputs = ["t_s", "contact_force_n"]\n{plate}{contact}{rest}')
        assert status("scene", file) == 0
        assert ("finger 1 lifts off: at 29.5 dB re 1 V the plate would pull it" in capsys.readouterr().out) == (
            force_n < 1
        )
        assert status("scene", file, "--json") == 0
        printed = json.loads(capsys.readouterr().out)
        pulled[force_n] = printed["pulls_n"][0]
        assert pulled[force_n] == pytest.approx(max(-printed["outputs"]["contact_force_n"]["min"] - force_n, 0.0))
    assert pulled[0.01] > 0 == pulled[20.0]


def test_lift_off_is_reported_without_force_output():
    found = load_scene(path_of("a4-screen"))
    peak_alone = replace(found.scene, outputs=("peak_m",), accuracy=0.1)
    (pulled,) = pulled_by(peak_alone, peak_alone.resolve(), found.given)
    assert pulled.lifts_off
    assert pulled.force_n == 2.0
    # a contact whose force is 10 N s/m times the speed of the plate under it, as the course of the plate has it
    course = replace(found.scene, outputs=("t_s", "focus_displacement_m"))
    course_values = course.resolve().run(found.given)
    speed_m_per_s = np.gradient(course_values["focus_displacement_m"], course_values["t_s"])
    assert pulled.pull_n == pytest.approx(-10.0 * speed_m_per_s.min(), rel=0.05)
    first_v = 10 ** (pulled.first_db_re_1v / 20)
    assert first_v == pytest.approx(found.given["voltage_v"] * 2.0 / pulled.pull_n)
    said = explanation(replace(course, accuracy=0.1), found.given)
    assert "finger 1 lifts off: at 29.5 dB re 1 V the plate would pull it by 9" in said
    assert "contact is lost from 16." in " ".join(said.split())


def test_next_digit_cost_comes_from_tenfold_accuracy_plan():
    found = load_scene(path_of("electrovibration-panel"))
    finer = replace(found.scene, accuracy=found.scene.accuracy / 10).resolve()
    ratio = finer.predicted_s / found.scene.resolve().predicted_s
    last = explanation(found.scene, found.given).splitlines()[-1]
    assert last.startswith(f"one more digit (accuracy {found.scene.accuracy / 10:g}): ")
    assert last.endswith(f", {ratio:.1f} times as long")


def test_measured_times_are_first_and_second_run(monkeypatch):
    found = load_scene(path_of("electrovibration-panel"))
    n_stages, runs = len(found.scene.resolve().stages), iter((12.5, 0.25))
    monkeypatch.setattr(Plan, "timed", lambda _plan, _values: (next(runs),) * n_stages)
    lines = explanation(found.scene, found.given).splitlines()
    assert sum(line.endswith("12.5 s   250 ms") for line in lines) == n_stages
    assert lines[-2].endswith(f"measured {12.5 * n_stages:.3g} s cold, {0.25 * n_stages:.3g} s warm")


def test_explanation_lists_every_effect_of_surface():
    found = load_scene(path_of("electrovibration-panel"))
    said = explanation(found.scene, found.given)
    kinds = {stage.effect for stage in found.scene.resolve().stages} - {""}
    for kind in found.scene.surface.effects:
        assert kind in kinds or f"\n{kind.ljust(24)}  off" in said, kind


def test_explanation_names_later_stages_only():
    found = load_scene(path_of("thin-screen"))
    said = explanation(replace(found.scene, outputs=("peak_m",)), found.given)
    assert "shear                     on    for attenuation, learning" in said
    assert "attenuation               on    for learning" in said


def test_explanation_marks_unneeded_effect_off():
    sliding = {"contacts": [{"force_n": 1.0, "speed_m_per_s": 0.05}], "given": {"level_db_re_1v": 20.0}}
    found = scene_of(table(effects=[LAW, {"kind": "friction"}], **sliding))
    assert "friction                  off   no output needs it" in explanation(found.scene, found.given)


def test_run_without_given_values_is_refused(tmp_path, capsys):
    file = tmp_path / "scene.toml"
    file.write_text(
        'outputs = ["peak_force_n"]\n[surface]\nkind = "electrovibration"\nfrequency_hz = 60\nduration_s = 0.05\n'
        'ramp_s = 0.01\n[[effects]]\nkind = "force_law"\nlaw = "sc_layer"\n',
        encoding="utf-8",
    )
    assert status("scene", file) == 2
    assert "given.level_db_re_1v: found no such key" in capsys.readouterr().err
    file.write_text(file.read_text(encoding="utf-8") + "[given]\nlevel_db_re_1v = 40.0\n", encoding="utf-8")
    assert status("scene", file, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert said["units"] == {"peak_force_n": "N"}
    assert 0.02 < said["outputs"]["peak_force_n"] < 0.022
    remedies = {'["peak_force_n"]': "add them to outputs", '["t_s", "peak_force_n"]': "add it to outputs"}
    for outputs, remedy in remedies.items():
        file.write_text(file.read_text(encoding="utf-8").replace('["peak_force_n"]', outputs), encoding="utf-8")
        assert status("scene", file, "--figure", tmp_path / "a.png") == 2
        assert remedy in capsys.readouterr().err
    wave = file.read_text(encoding="utf-8").replace('"peak_force_n"]', '"electrostatic_force_n"]')
    file.write_text(wave, encoding="utf-8")
    assert status("scene", file, "--explain", "--figure", tmp_path / "a.png") == 0
    assert "one more digit" in capsys.readouterr().out
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_the_figure_is_drawn(tmp_path, capsys):
    assert status("scene", "electrovibration-panel", "--figure", tmp_path / "a.png") == 0
    assert (tmp_path / "a.png").stat().st_size > 20_000
    assert "sensation" in capsys.readouterr().out
    assert status("scene", "electrovibration-panel", "--figure", tmp_path / "a.doc") == 2
    assert status("scene", "electrovibration-panel", "--figure", tmp_path / "no" / "a.png") == 3


@pytest.mark.parametrize("name", names())
def test_built_in_file_states_unverified_values(name):
    text = path_of(name).read_text(encoding="utf-8")
    assert "unverified" in text
    assert tomllib.loads(text)["title"]


def test_json_writes_null_for_infinite_level():
    @subcommand("scene")
    def command():
        say("", {"silent_db": -math.inf, "courses": [(1.0, math.nan)], "n": 3})

    printed = CliRunner().invoke(command, ["--json"]).output
    assert json.loads(printed) == {"silent_db": None, "courses": [[1.0, None]], "n": 3}
