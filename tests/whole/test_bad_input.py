"""Invalid study files: one sentence, exit status, no changes."""

import re

import pytest
from command_line import assert_one_sentence, call
from examples import examples
from hypothesis import given, strategies as st
from study_texts import TUTORIAL

from tactometry.errors import TactometryError
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, parse

THRESHOLD = builtin()["electrovibration-threshold"].read_text("utf-8")
FOCUS = builtin()["time-reversal-threshold"].read_text("utf-8")
FOCI = builtin()["time-reversal-localisation"].read_text("utf-8")
FALLING = """[procedure]
kind = "psi"
low = 40.0
high = 0.0
n_levels = 41
sd_low = 1.0
sd_high = 8.0

"""

STUDIES = {
    "unknown key": (
        TUTORIAL.replace("trial_s = 5.0", "trail_s = 5.0"),
        "s.toml, trail_s: found an unknown key, expected one of name, title, description, task, factors, stimulus, "
        "touch, procedure, limits, counterbalance, trial_s, consent, plan, nested, variants, practice, inquiries, "
        "forms, scene, sensation, observer, finger, texts, translations, images, analysis; did you mean 'trial_s'? "
        "(all keys: tactometry keys study)",
    ),
    "unknown table": (
        TUTORIAL.replace("[limits]", "[limit]"),
        "s.toml, limit: found an unknown key, expected one of name, title, description, task, factors, stimulus, "
        "touch, procedure, limits, counterbalance, trial_s, consent, plan, nested, variants, practice, inquiries, "
        "forms, scene, sensation, observer, finger, texts, translations, images, analysis; did you mean 'limits'? "
        "(all keys: tactometry keys study)",
    ),
    "missing key": (
        TUTORIAL.replace('name = "tutorial"\n', ""),
        "s.toml, name: found no such key, expected a text (all keys: tactometry keys study)",
    ),
    "missing table": (
        TUTORIAL.partition("[limits]")[0],
        "s.toml, limits: found no such key, expected a table (all keys: tactometry keys study)",
    ),
    "text for number": (
        TUTORIAL.replace("trial_s = 5.0", 'trial_s = "soon"'),
        "s.toml, trial_s: found 'soon', expected a number in s or a string such as '1 s' (one of s, ms, us, µs, "
        "min, h)",
    ),
    "wrong unit": (
        TUTORIAL.replace('duration_s = "500 ms"', 'duration_s = "500 mm"'),
        "s.toml, stimulus.duration_s: found '500 mm', expected a number in s or a string such as '1 s' (one of s, ms, "
        "us, µs, min, h)",
    ),
    "number for text": (
        TUTORIAL.replace('title = "Tutorial: is there a vibration under the finger?"', "title = 5"),
        "s.toml, title: found 5, expected a text",
    ),
    "list for number": (
        TUTORIAL.replace("catch_rate = 0.2", "catch_rate = [0.2]"),
        "s.toml, task.catch_rate: found [0.2], expected a number",
    ),
    "number for list": (
        TUTORIAL.replace("levels = [22, 28, 34, 40] ", "levels = 10 "),
        "s.toml, procedure.levels: found 10, expected a list of numbers",
    ),
    "table for list": (
        TUTORIAL.replace("frequency_hz = [60, 240]", "frequency_hz = {low = 60}"),
        "s.toml, factors.frequency_hz: found {'low': 60}, expected a list of numbers or texts",
    ),
    "empty list": (
        TUTORIAL.replace("[60, 240]", "[]"),
        "s.toml, factors.frequency_hz: found an empty list, expected at least one level",
    ),
    "duplicate factor level": (
        TUTORIAL.replace("[60, 240]", "[60, 60]"),
        "s.toml, factors.frequency_hz[1]: found 60.0 twice, expected each level once",
    ),
    "duplicate level": (
        TUTORIAL.replace("[22, 28, 34, 40]", "[10, 18, 18]"),
        "s.toml, procedure.levels[2]: found 18 twice, expected each level once; raise repeats to present it more often",
    ),
    "empty levels": (
        TUTORIAL.replace("[22, 28, 34, 40]", "[]"),
        "s.toml, procedure.levels: found none, expected at least one",
    ),
    "level above the limit": (
        TUTORIAL.replace("[22, 28, 34, 40]", "[10, 60]"),
        "s.toml, procedure: found the highest level 60, expected one within the limits (limits.voltage_peak_v: found a "
        "peak of 951.052 V, the limit is 100 V; lower the level; nothing was played)",
    ),
    "force above the limit": (
        TUTORIAL.replace("force_n = 1.0", "force_n = 9.0"),
        "s.toml, touch.force_n: found 9 N, expected one within the limits (limits.force_peak_n: found a force of up to "
        "10.8 N, the limit is 10 N; lower the target; nothing was played)",
    ),
    "a slide over a focus": (
        FOCUS.replace('kind = "press"', 'kind = "slide"\nspeed_m_per_s = 0.05'),
        "s.toml, touch.kind: found 'slide' with the stimulus 'focus', expected 'press', as a sliding "
        "finger leaves the focus; use 'hybrid' for focus and friction together",
    ),
    "a finger beside the plate": (
        FOCUS + "[sensation]\nfinger_x_m = -1.0\n",
        "s.toml, sensation.finger_x_m, finger_y_m: found (-1.0, 0.093) m, expected a point of the plate of 0.297 x "
        "0.21 m",
    ),
    "a place beside the plate": (
        FOCI.replace('middle = { x_m = "131 mm" }', 'middle = { x_m = "1 m" }'),
        "s.toml, stimulus.places.middle: found (1.0, 0.093) m, expected a point of the plate of 0.297 x 0.21 m",
    ),
    "two fingers on one place": (
        FOCI.replace('fingers = ["index", "middle"]', 'fingers = ["index", "index"]'),
        "s.toml, sensation.fingers[1]: found 'index' twice, expected each place once, as two fingers do not fit there",
    ),
    "two fingers that overlap": (
        FOCI.replace('middle = { x_m = "131 mm" }', 'middle = { x_m = "126 mm" }'),
        "s.toml, sensation.fingers: found index and middle 5 mm apart, expected at least the 10 mm of a fingertip; "
        "move a place or name fewer fingers",
    ),
    "more answers than places": (
        FOCI.replace('"index + middle"]', '"index + middle", "middle + index"]'),
        "s.toml, task.over: found 4 alternatives of 'place' at 3 places, expected a separate place for each "
        "alternative",
    ),
    "patches without a side": (
        FOCUS + "[stimulus.setup]\nside_m = 0.0\n",
        "s.toml, stimulus.setup.side_m: found 0.0, expected a finite number above 0",
    ),
    "a grid that falls": (
        re.sub(r"(?s)\[procedure\].*?(?=\[limits\])", FALLING, THRESHOLD),
        "s.toml, procedure.low: found 40, expected less than high (0)",
    ),
    "no voltage": (
        FOCUS.replace('pattern = "P0"', "voltage_max_v = 0.0"),
        "s.toml, stimulus.voltage_max_v: found 0.0, expected a finite number above 0",
    ),
    "no repeats": (
        TUTORIAL.replace("repeats = 4", "repeats = 0"),
        "s.toml, procedure.repeats: found 0, expected a whole number, at least 1",
    ),
    "unknown task": (
        TUTORIAL.replace('"yes_no"', '"yesno"'),
        "s.toml, task.kind: found 'yesno', expected one of yes_no, forced_choice, comparison, same_different, "
        "magnitude, adjustment, rating, localisation, preference, measurement; did you mean 'yes_no'?",
    ),
    "catch rate": (
        TUTORIAL.replace("catch_rate = 0.2", "catch_rate = 0.9"),
        "s.toml, task.catch_rate: found 0.9, expected a number from 0 to 0.5",
    ),
    "catch trials in forced choice": (
        TUTORIAL.replace('"yes_no"', '"forced_choice"'),
        "s.toml, task.catch_rate: found 0.2 with forced_choice, expected 0, as every trial of a forced choice "
        "contains a stimulus; remove the key",
    ),
    "unknown stimulus": (
        TUTORIAL.replace('"amplitude_modulated"', '"sinus"'),
        "s.toml, stimulus.kind: found 'sinus', expected one of amplitude_modulated, sine, square, triangle, trapezoid, "
        "pulse_train, step, wav, texture, focus, pattern, measured_focus, foci, hybrid; did you mean 'sine'?",
    ),
    "no kind": (
        TUTORIAL.replace('kind = "slide"\n', ""),
        "s.toml, touch.kind: found no such key, expected one of press, slide (all keys: tactometry keys touch)",
    ),
    "key of another kind": (
        THRESHOLD.replace('kind = "amplitude_modulated"', 'kind = "sine"\ncarrier_hz = 2000'),
        "s.toml, stimulus.carrier_hz: found an unknown key, expected one of frequency_hz, duration_s, ramp_s, rate_hz, "
        "phase_rad, level_unit (all keys: tactometry keys stimulus.sine)",
    ),
    "frequency above Nyquist": (
        TUTORIAL.replace("[60, 240]", "[60, 24000]").replace('"amplitude_modulated"', '"sine"'),
        None,
    ),
    "negative duration": (
        TUTORIAL.replace('"500 ms"', "-1"),
        None,
    ),
    "factor that changes nothing": (
        TUTORIAL.replace("frequency_hz = [60, 240]", "frequenz_hz = [60, 240]"),
        None,
    ),
    "factor and value": (
        TUTORIAL.replace('duration_s = "500 ms"', 'duration_s = "500 ms"\nfrequency_hz = 60'),
        "s.toml, stimulus.frequency_hz: found a value that is also a factor, expected only one of them; remove it "
        "here or in factors",
    ),
    "factor named as a column": (
        TUTORIAL.replace("frequency_hz = [60, 240]", "level = [60, 240]"),
        "s.toml, factors.level: found the name of a column in every trials table, expected another name",
    ),
    "counterbalance of no factor": (
        THRESHOLD.replace('["force_n", "frequency_hz"]', '["force_m"]'),
        "s.toml, counterbalance[0]: found 'force_m', expected each factor at most once (force_n, frequency_hz); did "
        "you mean 'force_n'?",
    ),
    "name": (
        TUTORIAL.replace('name = "tutorial"', 'name = "../up"'),
        "s.toml, name: found '../up', expected lower-case letters and digits joined by hyphens",
    ),
    "negative force": (
        TUTORIAL.replace("force_n = 1.0", "force_n = -1.0"),
        "s.toml, touch.force_n: found -1.0, expected a finite number above 0",
    ),
    "no limit": (
        TUTORIAL.replace("voltage_peak_v = 100.0", "voltage_peak_v = 0"),
        "s.toml, limits.voltage_peak_v: found 0.0, expected a finite number above 0",
    ),
    "infinite limit": (
        TUTORIAL.replace("voltage_peak_v = 100.0", "voltage_peak_v = inf"),
        's.toml, limits.voltage_peak_v: found inf, expected at most 5000, or "unlimited"',
    ),
    "not a number": (
        TUTORIAL.replace("voltage_peak_v = 100.0", "voltage_peak_v = nan"),
        "s.toml, limits.voltage_peak_v: found nan, expected a finite number above 0",
    ),
    "staircase steps": (
        THRESHOLD.replace("steps = [8.0, 4.0, 2.0]", "steps = [8.0, 0.0]"),
        "s.toml, procedure.steps[1]: found 0, expected above 0 and at most the range of levels (56)",
    ),
    "step of text": (
        THRESHOLD.replace("steps = [8.0, 4.0, 2.0]", 'steps = [8.0, "x"]'),
        "s.toml, procedure.steps[1]: found 'x', expected a number",
    ),
    "staircase start": (
        THRESHOLD.replace("start = 46.0", "start = 50.0"),
        "s.toml, procedure.start: found 50, expected a level between low (-10) and high (46)",
    ),
    "state of a procedure": (
        THRESHOLD.replace("start = 46.0", "start = 46.0\nreversals = [1.0]"),
        None,
    ),
    "lapse rate": (
        THRESHOLD.replace("lapse_rate = 0.02", "lapse_rate = 1.0"),
        None,
    ),
}
SYNTAX = {
    "no TOML": (
        "name = ",
        r"s\.toml: found no valid TOML \(Invalid value \(at end of document\)\), expected a study file",
    ),
    "key twice": ("a = 1\na = 2", r"s\.toml: found no valid TOML \(Cannot overwrite a value \(at .*\)\), .*"),
    "empty": ("", r"s\.toml, name: found no such key, expected a text \(all keys: tactometry keys study\)"),
}


@pytest.mark.parametrize("broken", STUDIES)
def test_broken_study_file_raises_one_sentence_error(tmp_path, capsys, monkeypatch, broken):
    content, message = STUDIES[broken]
    assert content not in (TUTORIAL, THRESHOLD)
    (tmp_path / "s.toml").write_text(content, "utf-8")
    monkeypatch.chdir(tmp_path)
    status, said, _ = call(capsys, "simulate", "s.toml", "--participants", 1, "--seed", 1, "--out", "d")
    assert status == 2
    assert_one_sentence(said)
    if message is not None:
        assert said == f"tactometry: {message}"
    assert "found" in said
    assert "expected" in said
    assert [path.name for path in tmp_path.iterdir()] == ["s.toml"]
    assert (tmp_path / "s.toml").read_text("utf-8") == content


@pytest.mark.parametrize("broken", SYNTAX)
def test_invalid_toml_is_refused_with_its_line(tmp_path, capsys, monkeypatch, broken):
    content, message = SYNTAX[broken]
    (tmp_path / "s.toml").write_text(content, "utf-8")
    monkeypatch.chdir(tmp_path)
    status, said, _ = call(capsys, "simulate", "s.toml", "--participants", 1, "--seed", 1, "--out", "d")
    assert status == 2
    assert re.fullmatch(f"tactometry: {message}", said.splitlines()[0])


def test_a_study_with_a_weighted_staircase_runs(tmp_path, capsys):
    study = THRESHOLD.replace('"staircase"', '"weighted_staircase"').replace("n_up = 1\n", "")
    study = study.replace("steps = [8.0, 4.0, 2.0]", "steps_up = [9.0, 3.0]\nsteps_down = [3.0, 1.0]")
    (tmp_path / "s.toml").write_text(study.replace("[30, 60, 120, 180, 240, 320, 480]", "[240]"), "utf-8")
    status, said, _ = call(
        capsys, "simulate", tmp_path / "s.toml", "--participants", 1, "--seed", 1, "--out", tmp_path / "d"
    )
    assert (status, said) == (0, "")
    assert b",weighted_staircase," in next((tmp_path / "d" / "data").glob("*.csv")).read_bytes()


@given(content=st.binary(max_size=300) | st.text(max_size=300).map(lambda text: text.encode("utf-8", "replace")))
def test_random_bytes_are_refused_as_study(content):
    with pytest.raises(TactometryError, match=r"(?s)found .*expected"):
        wire(parse(content, "s.toml"), "s.toml")


@given(place=st.integers(0, 10**6), byte=st.binary(min_size=0, max_size=3), length=st.integers(0, 4))
@examples(200)
def test_corrupted_study_file_is_read_or_refused(place, byte, length):
    whole = TUTORIAL.encode()
    start = place % len(whole)
    hit = whole[:start] + byte + whole[start + length :]
    refusal = refused(hit)
    assert refusal is None or re.search(r"(?s)s\.toml.*found .*expected", refusal)


def refused(content):
    """Return the reason why a study is refused, or None."""
    try:
        wire(parse(content, "s.toml"), "s.toml")
    except TactometryError as error:
        return str(error)
    return None
