"""Stimuli from files and custom stimuli, from the docs' examples."""

import hashlib
import io
import json
import re
import struct
import tomllib

import numpy as np
import pytest
from command_line import call, output, refused
from places import DOCS
from scipy.io import wavfile
from study_texts import TUTORIAL, changed
from tables import trial_rows

from tactometry.devices.outputs.file import read_signal
from tactometry.experiments.bench.preflight import _study
from tactometry.stimuli.electrovibration.waveforms.wav_file import WavFile

PAGE = (DOCS / "reference" / "studies.md").read_text("utf-8")
SECTION = PAGE.partition("## Files and custom code")[2].partition("\n## ")[0]
FILE_TABLE, OWN_TABLES = re.findall(r"```toml\n(.*?)```", SECTION, re.S)
(CODE,) = re.findall(r"```python\n(.*?)```", SECTION, re.S)
BEFORE, _, REST = TUTORIAL.partition("[factors]\nfrequency_hz = [60, 240]\n")
AFTER = REST[REST.index("[touch]") :]
SHORT = {"levels = [22, 28, 34, 40]": "levels = [22, 40]", "repeats = 4": "repeats = 1", '"300 ms"': '"10 ms"'}
"""Of a session that is played in real time."""
RATE_HZ, N_SAMPLES = 48_000, 24_000
TONE = 0.5 * np.sin(2 * np.pi * 100 * np.arange(N_SAMPLES) / RATE_HZ)
ALL = ("--participants", "2", "--seed", "4")


def with_stimulus(tables, factors="force_n = [0.5, 2.0]"):
    touch = AFTER if "force_n" not in factors else AFTER.replace("force_n = 1.0\n", "", 1)
    return f"{BEFORE}[factors]\n{factors}\n\n{tables}\n{touch}"


def wav(samples, rate_hz=RATE_HZ):
    file = io.BytesIO()
    wavfile.write(file, rate_hz, samples)
    return file.getvalue()


def as_int16(samples):
    return np.round(32768 * np.asarray(samples)).astype("<i2")


def digest(content):
    return hashlib.sha256(content).hexdigest()


def shorten(study):
    study.write_text(changed(study.read_text(), SHORT))


@pytest.fixture
def own(tmp_path, monkeypatch):
    place = tmp_path / "studies"
    place.mkdir()
    (place / "mine.py").write_text(CODE)
    (place / "own.toml").write_text(with_stimulus(OWN_TABLES))
    monkeypatch.chdir(tmp_path)
    return place / "own.toml"


@pytest.fixture
def filed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    content = wav(as_int16(TONE))
    (tmp_path / "buzz.wav").write_bytes(content)
    stated = FILE_TABLE.replace('sha256 = ""', f'sha256 = "{digest(content)}"')
    (tmp_path / "filed.toml").write_text(with_stimulus(stated))
    return tmp_path / "filed.toml"


# --- of one's own


def test_own_stimulus_data_are_validated_without_code(own, tmp_path, capsys):
    root = tmp_path / "d"
    output(capsys, "simulate", own, *ALL, "--out", root, "--allow-code")
    own.with_name("mine.py").unlink()
    for command in ("validate", "replay"):
        assert call(capsys, command, root)[0] == 0
    rows = [row for row in trial_rows(root) if row["response"]]
    felt = {level: np.mean([float(row["response"]) for row in rows if row["level"] == level]) for level in ("22", "40")}
    assert felt["22"] < felt["40"]  # 8 dB below its threshold, and 10 above


def test_own_signals_reach_the_output_unchanged(own, tmp_path, capsys, monkeypatch):
    shorten(own)
    bench = tmp_path / "bench.toml"
    bench.write_text('[output]\nkind = "file"\nfolder = "played"\nramp_s = 0\n')
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 300))
    words = ("run", own, "--participant", "P01", "--rig", "console", "--bench", bench, "--out", tmp_path / "d")
    refused = call(capsys, *words)
    assert refused[0] == 2
    assert "stimulus.kind: found 'mine:Chirp', a stimulus whose code would run, expected --allow-code" in refused[1]
    assert not (tmp_path / "d").exists()
    assert call(capsys, *words, "--allow-code", "--seed", "3")[0] == 0
    made = {}
    exec(compile(CODE, "mine.py", "exec"), made)
    stated = {key: value for key, value in tomllib.loads(OWN_TABLES)["stimulus"].items() if key != "kind"}
    chirp = made["Chirp"](**{**stated, "duration_s": 0.5})
    levels = [float(row["level"]) for row in trial_rows(tmp_path / "d") if row["level"]]
    first = read_signal(next(iter(sorted((tmp_path / "played").glob("*.npz")))))
    assert np.array_equal(first.samples, chirp.at(levels[0]).samples)


def test_own_stimulus_does_not_run_without_permission(own, tmp_path, capsys):
    own.with_name("mine.py").write_text("raise SystemExit('it ran')\n")
    sentence = "a stimulus whose code would run, expected --allow-code"
    for words in (("simulate", own, *ALL, "--out", tmp_path / "d"), ("run", own, "--participant", "P1", "--dry-run")):
        said = refused(capsys, *words)
        assert sentence in said
    [found], _ = _study(str(own), allow_code=False)  # of `check`
    assert (found.fine, sentence in found.found) == (False, True)


def test_own_sensation_needs_permission_to_simulate(own, tmp_path, capsys):
    stimulus = '[factors]\nfrequency_hz = [60, 240]\n\n[stimulus]\nkind = "sine"\n'
    own.write_text(BEFORE + stimulus + OWN_TABLES[OWN_TABLES.index("[sensation]") :] + AFTER)
    said = refused(capsys, "simulate", own, *ALL, "--out", tmp_path / "d")
    assert "sensation.kind: found 'mine:Felt', a sensation model whose code would run, expected --allow-" in said
    assert call(capsys, "run", own, "--participant", "P01", "--rig", "console", "--dry-run")[0] == 0
    assert call(capsys, "simulate", own, *ALL, "--out", tmp_path / "d", "--allow-code")[0] == 0


SIGNAL = '        return Signal(10 ** (level / 20) * (envelope * np.sin(2 * np.pi * turns))[None], self.rate_hz, "V")'
COMPLEX = SIGNAL.replace("[None]", "[None] * 1j")
UNCHECKED = 'Unchecked = type("Unchecked", (Signal,), {"__post_init__": print})'
"""A subclass that does not check its samples."""


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (SIGNAL, "        return 1 / 0", "found ZeroDivisionError (division by zero) in at, expected an answer"),
        (SIGNAL, "        return 3.0", "found 3.0 as the answer of at, expected a Signal (tactometry.signal)"),
        (SIGNAL, "        return list(range(4000))", "letters) ..."),
        (SIGNAL, SIGNAL.replace('"V"', '"m"'), "mine:Chirp.at(40): found a signal in 'm', expected the voltage at"),
        (SIGNAL, SIGNAL.replace("[None]", "[None, :900]"), "found a signal of 0.045 s, expected 0.5 s, as stated by"),
        (SIGNAL, COMPLEX, "Signal.samples: found values of type complex128, expected"),
        (SIGNAL, f"        {UNCHECKED}\n{COMPLEX.replace('Signal(', 'Unchecked(')}", "found values of type complex128"),
        ("    level_unit: str\n", "    unit: str = 'V'\n", "found 'mine:Chirp', which lacks level_unit"),
        ("    def at(", "    def out(", "found 'mine:Chirp', which lacks at(level)"),
        ("    low_hz: float\n", "    low_hz: float\n    force_n: float\n", "the field force_n, a key of the touch"),
        ("class Chirp", "class Tone", "stimulus.kind: found no dataclass 'Chirp' in mine.py"),
        ("    high_hz: float\n", "    top_hz: float\n", "stimulus.high_hz: found an unknown key, expected one of"),
        ("    def sensation_db", "    def felt_db", "found 'mine:Felt', which lacks sensation_db(signal, contact)"),
        (
            "        if signal.peak == 0:\n            return -np.inf\n",
            "        return np.nan\n",
            "found nan as the answer of sensation_db, expected a number in dB, or -inf if nothing is felt",
        ),
    ],
)
def test_flawed_own_stimulus_is_refused(own, tmp_path, capsys, old, new, sentence):
    own.with_name("mine.py").write_text(changed(CODE, {old: new}))
    code, said, _ = call(capsys, "simulate", own, *ALL, "--out", tmp_path / "d", "--allow-code")
    assert code == 2
    assert sentence in said.splitlines()[0]
    assert len(said.splitlines()[0]) < 700


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('duration_s = "500 ms"\n', "", "stimulus.duration_s: found no such key, expected duration_s = ... in"),
        ('"mine:Chirp"', '"mine.py:Chirp"', "found 'mine.py:Chirp', expected the module without '.py': 'mine:Chirp'"),
    ],
)
def test_flawed_table_of_own_stimulus_is_refused(own, tmp_path, capsys, old, new, sentence):
    own.write_text(own.read_text().replace(old, new, 1))
    assert sentence in refused(capsys, "simulate", own, *ALL, "--out", tmp_path / "d", "--allow-code")


def test_own_factor_names_stimuli_without_the_code(own, tmp_path, capsys):
    own.write_text(with_stimulus(OWN_TABLES.replace("low_hz = 40.0\n", ""), "low_hz = [40, 80]"))
    output(capsys, "simulate", own, *ALL, "--out", tmp_path / "d", "--allow-code")
    assert call(capsys, "validate", tmp_path / "d")[0] == 0
    assert call(capsys, "replay", tmp_path / "d")[0] == 0


# --- from a file


def test_wav_file_is_played_and_data_read_without(filed, tmp_path, capsys, monkeypatch):
    shorten(filed)
    (tmp_path / "bench.toml").write_text('[output]\nkind = "file"\nfolder = "played"\nramp_s = 0\n')
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 300))
    words = ("--participant", "P01", "--rig", "console", "--bench", "bench.toml", "--out", tmp_path / "d")
    assert call(capsys, "run", filed, *words)[0] == 0
    [(trial, level), *_] = [(row["trial"], float(row["level"])) for row in trial_rows(tmp_path / "d") if row["level"]]
    played = read_signal(tmp_path / "played" / "0001.npz")
    wanted = as_int16(TONE) / as_int16(TONE).max() * 10 ** (level / 20)
    assert (played.rate_hz, played.samples.shape) == (RATE_HZ, (1, N_SAMPLES))
    assert played.samples[0] == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    shown = ("show", tmp_path / "d", "--trial", trial, "--figure", tmp_path / "shown.svg")
    with_it = output(capsys, *shown)
    (tmp_path / "buzz.wav").unlink()
    for command in ("validate", "replay"):
        assert call(capsys, command, tmp_path / "d")[0] == 0
    assert "emitted" in with_it
    assert output(capsys, *shown) != with_it  # computed anew from the file alone
    study = (tmp_path / "d" / "study.toml").read_text()
    assert f'sha256 = "{digest(wav(as_int16(TONE)))}"' in study  # whose own digest is in the head of the journal


def test_wav_file_is_found_next_to_study(filed, tmp_path, capsys, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    output(capsys, "run", "../filed.toml", "--participant", "P01", "--rig", "simulated", "--dry-run")
    (tmp_path / "buzz.wav").unlink()
    said = refused(capsys, "run", "../filed.toml", "--participant", "P01", "--rig", "simulated", "--dry-run")
    assert "../buzz.wav" in said


def test_wav_file_is_felt(filed, tmp_path, capsys):
    output(capsys, "simulate", filed, *ALL, "--out", tmp_path / "d")
    plan = json.loads(output(capsys, "run", filed, "--participant", "P01", "--dry-run", "--json"))
    assert plan["felt"][0]["stimulus"].startswith("wav")


UNSOUND = {
    "another rate": (wav(as_int16(TONE), 44_100), "stimulus.rate_hz: found a file at 44100 Hz, expected 48000 Hz"),
    "another length": (wav(as_int16(TONE[:12_000])), "stimulus.duration_s: found 0.5 s, expected 0.25 s, the file's"),
    "clipped": (wav(as_int16(np.clip(3 * TONE, -1, 1 - 2**-15))), "3 neighbouring samples at full scale, from "),
    "clipped, floating": (wav(np.clip(3 * TONE, -1, 1)), "3 neighbouring samples at full scale, from "),
    "empty": (wav(np.empty(0, "<i2")), "found no samples, expected at least one"),
    "silent": (wav(np.zeros(N_SAMPLES, "<i2")), "found only zeros, expected a sample that is not 0"),
    "stereo": (wav(np.stack([as_int16(TONE)] * 2, axis=1)), "found 2 channels, expected one; keep the intended"),
    "not a number": (wav(np.where(np.arange(N_SAMPLES) == 7, np.nan, TONE)), "found nan as sample 7, expected finite"),
    "no WAV": (b"OggS" + bytes(100), "found no WAV file, expected a file that begins with RIFF and WAVE"),
    "nothing": (b"", "found no WAV file"),
    "cut off": (wav(as_int16(TONE))[:1000], "found 956 of 48000 bytes of samples, expected all: the file is"),
    "cut off in its head": (wav(as_int16(TONE))[:20], "found no complete chunk 'fmt ', expected a complete one: the"),
}


@pytest.mark.parametrize("what", UNSOUND)
def test_unplayable_file_is_refused_in_one_sentence(filed, tmp_path, capsys, what):
    content, sentence = UNSOUND[what]
    (tmp_path / "buzz.wav").write_bytes(content)
    filed.write_text(re.sub('sha256 = ".*?"', f'sha256 = "{digest(content)}"', filed.read_text()))
    said = refused(capsys, "simulate", filed, *ALL, "--out", tmp_path / "d")
    assert sentence in said
    assert not (tmp_path / "d").exists()


def test_wav_file_needs_its_digest_and_allowed_levels(filed, tmp_path, capsys):
    filed.write_text(filed.read_text().replace("voltage_peak_v = 100.0", "voltage_peak_v = 90.0"))
    said = refused(capsys, "run", filed, "--participant", "P01", "--dry-run")
    assert "limits.voltage_peak_v: found a peak of 100" in said
    content = wav(as_int16(0.9 * TONE))
    (tmp_path / "buzz.wav").write_bytes(content)
    said = refused(capsys, "run", filed, "--participant", "P01", "--dry-run")
    assert f"expected '{digest(content)}', the digest of {tmp_path / 'buzz.wav'}" in said


def test_wav_level_re_file_keeps_sample_values(tmp_path):
    """At 0 dB, samples of a file in volts are unchanged; 20 dB multiply by 10."""
    content = wav(3.0 * TONE)
    (tmp_path / "x.wav").write_bytes(content)
    stated = {"path": str(tmp_path / "x.wav"), "rate_hz": RATE_HZ, "duration_s": 0.5, "sha256": digest(content)}
    file = WavFile(**stated, level_unit="dB re file", volts_per_unit=1.0)
    assert np.array_equal(file.at(0.0).samples[0], 3.0 * TONE)
    assert file.at(20.0).samples[0] == pytest.approx(30.0 * TONE)
    assert WavFile(**stated, level_unit="V").at(7.0).peak == pytest.approx(7.0)


@pytest.mark.parametrize("form", ["u1", "<i2", "<i4", "<f4", "<f8", "24 bits"])
def test_each_form_is_the_same_voltage(tmp_path, form):
    """The tolerance is half of the last bit of each form."""
    if form == "24 bits":
        body = b"".join(struct.pack("<i", round(value * 2**23))[:3] for value in TONE)
        head = struct.pack("<4sI4s4sIHHIIHH4sI", b"RIFF", 36 + len(body), b"WAVE", b"fmt ", 16, 1, 1, RATE_HZ,
                           3 * RATE_HZ, 3, 24, b"data", len(body))  # fmt: skip
        content, step = head + body, 2.0**-23
    elif form == "u1":
        content, step = wav(np.round(128 * TONE + 128).astype("u1")), 2.0**-7
    elif form[1] == "i":
        bits = 8 * int(form[2]) - 1
        content, step = wav(np.round(2.0**bits * TONE).astype(form)), 2.0**-bits
    else:
        content, step = wav(TONE.astype(form)), 1e-7
    (tmp_path / "x.wav").write_bytes(content)
    stated = {"path": str(tmp_path / "x.wav"), "rate_hz": RATE_HZ, "duration_s": 0.5, "sha256": digest(content)}
    samples = WavFile(**stated, level_unit="dB re file", volts_per_unit=1.0).at(0.0).samples[0]
    assert np.abs(samples - TONE).max() <= step / 2
