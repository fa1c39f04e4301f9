"""Invalid study files: one sentence, exit status, no changes."""

import re

import pytest
from command_line import assert_one_sentence, call
from examples import examples
from hypothesis import given, strategies as st
from study_texts import TUTORIAL, changed

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
STAIRCASE = THRESHOLD[THRESHOLD.index("[procedure]") : THRESHOLD.index("[limits]")]
AM, POSITIVE = '"amplitude_modulated"', "expected a finite number above 0"

ROOT_KEYS = "expected one of name, title, description, task, factors, "
STUDIES = [
    (TUTORIAL, "trial_s = 5.0", "trail_s = 5.0", f"trail_s: found an unknown key, {ROOT_KEYS}"),
    (TUTORIAL, "[limits]", "[limit]", f"limit: found an unknown key, {ROOT_KEYS}"),
    (TUTORIAL, 'name = "tutorial"\n', "", "name: found no such key, expected a text (all keys: tactometry keys study)"),
    (TUTORIAL, "[limits]\nvoltage_peak_v = 100.0\n", "", "limits: found no such key, expected a table (all keys:"),
    (TUTORIAL, "trial_s = 5.0", 'trial_s = "soon"', "trial_s: found 'soon', expected a number in s or a string such"),
    (TUTORIAL, '"500 ms"', '"500 mm"', "stimulus.duration_s: found '500 mm', expected a number in s or a string such"),
    (TUTORIAL, '"Tutorial: is there a vibration under the finger?"', "5", "title: found 5, expected a text"),
    (TUTORIAL, '"Tutorial: is there a vibration under the finger?"', '""', "title: found nothing, expected a text"),
    (TUTORIAL, 'description = "', 'description = "" # ', "description: found nothing, expected a text"),
    (TUTORIAL, "catch_rate = 0.2", 'rest_s = "1 min"', "task.rest_s: found 60 s without rest_after, expected"),
    (TUTORIAL, "catch_rate = 0.2", 'interleaving = "balanced"', "task.interleaving: found 'balanced' without"),
    (TUTORIAL, "catch_rate = 0.2", "catch_rate = 5e-324", "task.catch_rate: found 4.94066e-324, expected 0, or at"),
    (TUTORIAL, "catch_rate = 0.2", "catch_rate = [0.2]", "task.catch_rate: found [0.2], expected a number"),
    (TUTORIAL, "[22, 28, 34, 40] ", "10 ", "procedure.levels: found 10, expected a list of numbers"),
    (TUTORIAL, "[60, 240]", "{low = 60}", "factors.frequency_hz: found {'low': 60}, expected a list of numbers or"),
    (TUTORIAL, "[60, 240]", "[]", "factors.frequency_hz: found an empty list, expected at least one level"),
    (TUTORIAL, "[60, 240]", "[60, 60]", "factors.frequency_hz[1]: found 60.0 twice, expected each level once"),
    (TUTORIAL, "[22, 28, 34, 40]", "[10, 18, 18]", "procedure.levels[2]: found 18 twice, expected each level once"),
    (TUTORIAL, "[22, 28, 34, 40]", "[]", "procedure.levels: found none, expected at least one"),
    (TUTORIAL, "[22, 28, 34, 40]", "[10, 60]", "procedure: found the highest level 60, expected one within the limits"),
    (TUTORIAL, "force_n = 1.0", "force_n = 9.0", "touch.force_n: found 9 N, expected one within the limits"),
    (
        FOCUS,
        'kind = "press"',
        'kind = "slide"\nspeed_m_per_s = 0.05',
        "touch.kind: found 'slide' with the stimulus 'focus', expected 'press', as a sliding finger leaves the focus",
    ),
    (
        FOCUS,
        "[limits]",
        "[sensation]\nfinger_x_m = -1.0\n[limits]",
        "sensation.finger_x_m, finger_y_m: found (-1.0, 0.093) m, expected a point of the plate of 0.297 x 0.21 m",
    ),
    (FOCI, '"131 mm" }', '"1 m" }', "stimulus.places.middle: found (1.0, 0.093) m, expected a point of the plate of"),
    (FOCI, '["index", "middle"]', '["index", "index"]', "sensation.fingers[1]: found 'index' twice, expected each"),
    (FOCI, '"131 mm" }', '"126 mm" }', "sensation.fingers: found index and middle 5 mm apart, expected at least the"),
    (FOCI, '"index + middle"]', '"index + middle", "middle + index"]', "task.over: found 4 alternatives of 'place' at"),
    (FOCUS, "[limits]", "[stimulus.setup]\nside_m = 0.0\n[limits]", f"stimulus.setup.side_m: found 0.0, {POSITIVE}"),
    (THRESHOLD, STAIRCASE, FALLING, "procedure.low: found 40, expected less than high (0)"),
    (FOCUS, 'pattern = "P0"', "voltage_max_v = 0.0", f"stimulus.voltage_max_v: found 0.0, {POSITIVE}"),
    (TUTORIAL, "repeats = 4", "repeats = 0", "procedure.repeats: found 0, expected a whole number, at least 1"),
    (TUTORIAL, '"yes_no"', '"yesno"', "task.kind: found 'yesno', expected one of yes_no, forced_choice, comparison, "),
    (TUTORIAL, "catch_rate = 0.2", "catch_rate = 0.9", "task.catch_rate: found 0.9, expected a number from 0 to 0.5"),
    (TUTORIAL, '"yes_no"', '"forced_choice"', "task.catch_rate: found 0.2 with forced_choice, expected 0, as every"),
    (TUTORIAL, AM, '"sinus"', "stimulus.kind: found 'sinus', expected one of amplitude_modulated, sine, square, "),
    (TUTORIAL, 'kind = "slide"\n', "", "touch.kind: found no such key, expected one of press, slide (all keys:"),
    (THRESHOLD, AM, '"sine"\ncarrier_hz = 2000', "stimulus.carrier_hz: found an unknown key, expected one of"),
    (TUTORIAL, "[60, 240]", "[60, 24000]", "stimulus.carrier_hz + frequency_hz: found 26000.0 Hz"),
    (TUTORIAL, '"500 ms"', "-1", "stimulus.duration_s: found "),
    (TUTORIAL, "frequency_hz = [60, 240]", "frequenz_hz = [60, 240]", "factors.frequenz_hz: found "),
    (TUTORIAL, '"500 ms"', '"500 ms"\nfrequency_hz = 60', "stimulus.frequency_hz: found a value that is also a factor"),
    (TUTORIAL, "frequency_hz = [60, 240]", "level = [60, 240]", "factors.level: found the name of a column in every"),
    (THRESHOLD, '["force_n", "frequency_hz"]', '["force_m"]', "counterbalance[0]: found 'force_m', expected each"),
    (TUTORIAL, 'name = "tutorial"', 'name = "../up"', "name: found '../up', expected lower-case letters and digits"),
    (TUTORIAL, "force_n = 1.0", "force_n = -1.0", f"touch.force_n: found -1.0, {POSITIVE}"),
    (TUTORIAL, "voltage_peak_v = 100.0", "voltage_peak_v = 0", f"limits.voltage_peak_v: found 0.0, {POSITIVE}"),
    (TUTORIAL, "voltage_peak_v = 100.0", "voltage_peak_v = inf", "limits.voltage_peak_v: found inf, expected at most"),
    (TUTORIAL, "voltage_peak_v = 100.0", "voltage_peak_v = nan", f"limits.voltage_peak_v: found nan, {POSITIVE}"),
    (THRESHOLD, "[8.0, 4.0, 2.0]", "[8.0, 0.0]", "procedure.steps[1]: found 0, expected above 0 and at most the range"),
    (THRESHOLD, "[8.0, 4.0, 2.0]", '[8.0, "x"]', "procedure.steps[1]: found 'x', expected a number"),
    (THRESHOLD, "start = 46.0", "start = 50.0", "procedure.start: found 50, expected a level between low (-10) and"),
    (THRESHOLD, "start = 46.0", "start = 46.0\nreversals = [1.0]", "procedure.reversals: found "),
    (THRESHOLD, "lapse_rate = 0.02", "lapse_rate = 1.0", "observer.lapse_rate: found "),
]
"""Study, text, what replaces it, and how the refusal begins."""
SYNTAX = {
    "no TOML": ("name = ", r"found no valid TOML \(Invalid value \(at end of document\)\), expected a study file"),
    "key twice": ("a = 1\na = 2", r"found no valid TOML \(Cannot overwrite a value \(at .*\)\), .*"),
}


def simulated(capsys, folder, content):
    (folder / "s.toml").write_text(content, "utf-8")
    return call(capsys, "simulate", "s.toml", "--participants", 1, "--seed", 1, "--out", "d")[:2]


@pytest.mark.parametrize(("study", "old", "new", "message"), STUDIES, ids=lambda text: text.partition(":")[0][:40])
def test_broken_study_file_raises_one_sentence_error(tmp_path, capsys, monkeypatch, study, old, new, message):
    monkeypatch.chdir(tmp_path)
    content = changed(study, {old: new})
    status, said = simulated(capsys, tmp_path, content)
    assert status == 2
    assert_one_sentence(said)
    assert said.startswith(f"tactometry: s.toml, {message}")
    assert "expected" in said
    assert [path.name for path in tmp_path.iterdir()] == ["s.toml"]
    assert (tmp_path / "s.toml").read_text("utf-8") == content


@pytest.mark.parametrize(
    ("study", "old", "new", "hint"),
    [
        (TUTORIAL, "trial_s = 5.0", "trail_s = 5.0", "trial_s"),
        (TUTORIAL, "[limits]", "[limit]", "limits"),
        (TUTORIAL, '"yes_no"', '"yesno"', "yes_no"),
        (TUTORIAL, AM, '"sinus"', "sine"),
        (THRESHOLD, '["force_n", "frequency_hz"]', '["force_m"]', "force_n"),
    ],
)
def test_refusal_names_the_nearest_name(tmp_path, capsys, monkeypatch, study, old, new, hint):
    monkeypatch.chdir(tmp_path)
    assert f"; did you mean '{hint}'?" in simulated(capsys, tmp_path, changed(study, {old: new}))[1]


@pytest.mark.parametrize("broken", SYNTAX)
def test_invalid_toml_is_refused_with_its_line(tmp_path, capsys, monkeypatch, broken):
    content, message = SYNTAX[broken]
    monkeypatch.chdir(tmp_path)
    status, said = simulated(capsys, tmp_path, content)
    assert status == 2
    assert re.fullmatch(rf"tactometry: s\.toml: {message}", said)


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
    try:
        wire(parse(content, "s.toml"), "s.toml")
    except TactometryError as error:
        return str(error)
    return None
