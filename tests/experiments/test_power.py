"""The command `power`: refusals, its folder, and reproducible bytes."""

import io
import re
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest
from command_line import call, output, refused, status
from places import ROOT
from pyarrow import parquet
from study_texts import TUTORIAL

from tactometry.experiments.power.design import participants_of
from tactometry.experiments.study.study_file import load

ASKED = ("power", "tutorial", "--effect", "frequency_hz: 8 dB", "--participants", "3,4", "--seed", "5", "--most", "3")


def files(root):
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    root = tmp_path_factory.mktemp("alone") / "p"
    assert status(*ASKED, "--out", root) == 0
    return files(root)


def restore(root, contents):
    for name, content in contents.items():
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_bytes(content)


def test_power_creates_no_folder_without_pyarrow(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    code, said, _ = call(capsys, *ASKED, "--out", tmp_path / "p")
    assert code == 3
    assert re.search(r"power --out: found no pyarrow \(.*\), .*; pip install 'tactometry\[power\]'$", said)
    assert not (tmp_path / "p").exists()


REFUSALS = [
    ("tutorial", ["--effect", "voltage: 2 dB"], "expected a factor of the study (frequency_hz)"),
    ("tutorial", ["--effect", "frequency_hz: 2"], "without a unit"),
    ("tutorial", ["--effect", "frequency_hz: 2 m"], "found the unit 'm', expected one of dB, dB SL"),
    ("tutorial", ["--effect", "frequency_hz: 60 = 2 dB, 240 = 1 dB SL"], "one unit for all levels"),
    ("tutorial", ["--effect", "frequency_hz: 61 = 2 dB"], "expected a level of frequency_hz (60, 240)"),
    ("tutorial", ["--effect", "frequency_hz: 0 dB"], "expected an effect other than 0"),
    ("tutorial", ["--effect", "frequency_hz: 2 points"], "the unit 'points', expected one of dB, dB SL"),
    ("tutorial", ["--participants", "9..6"], "a descending range"),
    ("tutorial", ["--participants", "six"], "expected a range such as 6..24"),
    ("tutorial", ["--participants", "0..6"], "expected from 3 to 999"),
    ("tutorial", ["--target", "1"], "--target: found 1, expected above 0 and below 1"),
    ("tutorial", ["--keep-data"], "--keep-data: found no --out"),
    ("tutorial", ["--resume"], "--resume: found no --out"),
    ("grating-roughness", ["--effect", "period_m: 2 dB"], "% exponent, such as 'period_m: 20 % exponent'"),
    ("texture-discrimination", ["--effect", "period_m: 2 dB"], "one of dB PSE, % JND, such as 'period_m: 20 % JND'"),
    ("texture-discrimination", ["--effect", "period_m: -100 % JND"], "expected a change above -100 %"),
    ("time-reversal-localisation", ["--effect", "place: 2 dB"], "whose levels are the alternatives of a trial"),
    ("time-reversal-localisation", ["--effect", "distance_m: 6 dB SL"], "whose levels have different places"),
    ("force-loss", ["--effect", "force_n: 2 dB"], "not sensations of a participant"),
    ("hybrid-button", ["--effect", "feedback: 2 dB SL"], "the unit 'dB SL', expected points, the unit of scores"),
    ("hybrid-button", ["--effect", "envelope: 1 points"], "expected a factor of the study (feedback)"),
    ("time-reversal-patterns", ["--effect", "envelope: sine = 1 points"], "a level of envelope (rectangular, "),
    (
        "time-reversal-patterns",
        ["--effect", "pattern: P3 = 1 points", "--dependent", "beauty"],
        "--dependent: found 'beauty', expected one of PQ",
    ),
]


@pytest.mark.parametrize(("study", "options", "expected"), REFUSALS)
def test_invalid_power_options_give_one_sentence(capsys, study, options, expected):
    assert expected in refused(capsys, "power", study, *ASKED[2:], *options)


def test_unsuitable_study_file_is_refused(capsys, tmp_path):
    (path := tmp_path / "study.toml").write_text(TUTORIAL, "utf-8")
    said = refused(capsys, "power", path, *ASKED[2:], "--trials", "41")
    assert "expected a multiple of the number of levels" in said
    path.write_text(TUTORIAL.replace("frequency_hz = [60, 240]", "frequency_hz = [60]"), "utf-8")
    said = refused(capsys, "power", path, *ASKED[2:])
    assert "with one level (60), expected a factor with two or more levels" in said


OWN = """
from tactometry.observers.signal_detection import SignalDetectionObserver

class Mine(SignalDetectionObserver):
    pass
"""


@pytest.fixture
def own(tmp_path):
    _, content = load("tutorial")
    (tmp_path / "mine.py").write_text(OWN)
    path = tmp_path / "own.toml"
    path.write_bytes(content.partition(b"\n[observer")[0] + b'\n[observer]\nkind = "mine:Mine"\n')
    return path


def test_custom_observer_requires_allow_code(capsys, own):
    words = ("power", own, *ASKED[2:-1], "1")
    said = refused(capsys, *words)
    assert "found 'mine:Mine', an observer whose code would run, expected --allow-code" in said
    assert "of simulated participants, seed 5" in output(capsys, *words, "--allow-code")


def test_observer_without_traits_is_refused(capsys, own):
    guesser = (ROOT / "tests" / "recipes" / "tactometry" / "observers" / "guesser.py").read_text("utf-8")
    (own.parent / "mine.py").write_text(guesser.replace("from ..arguments", "from tactometry.arguments"))
    own.write_bytes(own.read_bytes().replace(b"Mine", b"Guesser"))
    said = refused(capsys, "power", own, *ASKED[2:], "--allow-code")
    assert "observer.kind: found 'mine:Guesser', which does not accept [observer.people]" in said


@pytest.mark.slow
def test_interrupted_power_command_resumes_to_same_bytes(capsys, tmp_path):
    words = [*ASKED, "--trials", "20,60", "--out"]  # a short batch, then three: time enough to be stopped in
    process = subprocess.Popen(
        [sys.executable, "-m", "tactometry", *words, tmp_path / "p"], stderr=subprocess.PIPE, text=True
    )
    while process.poll() is None and not list((tmp_path / "p").glob("studies/*.parquet")):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.strip() == "tactometry: interrupted; recorded data are safe: continue with --resume"
    assert not (tmp_path / "p" / "power.csv").exists()
    output(capsys, *words, tmp_path / "p", "--resume")
    output(capsys, *words, tmp_path / "alone")
    assert files(tmp_path / "p") == files(tmp_path / "alone")


def test_missing_batch_is_recomputed_to_same_bytes(capsys, tmp_path, alone):
    restore(tmp_path, alone)
    lost = sorted(tmp_path.glob("studies/*"))[-1]
    lost.unlink()
    (tmp_path / "power.csv").unlink()
    assert "continue with --resume" in refused(capsys, *ASKED, "--out", tmp_path)
    output(capsys, *ASKED, "--out", tmp_path, "--resume")
    assert files(tmp_path) == alone


def test_kept_trials_are_marked_as_simulated(capsys, tmp_path, alone):
    """The rows are the same if the first run did not keep trials."""
    restore(tmp_path, alone)
    output(capsys, *ASKED, "--out", tmp_path, "--resume", "--keep-data")
    kept = sorted(tmp_path.glob("data/*.parquet"))
    assert {name: content for name, content in files(tmp_path).items() if not name.startswith("data")} == alone
    rows = pd.concat(map(pd.read_parquet, sorted(tmp_path.glob("studies/*.parquet"))))
    assert len(kept) == len(rows) / len(participants_of("3,4"))
    assert all(parquet.read_schema(path).metadata[b"simulated"] == b"true" for path in kept)
    trials = pd.read_parquet(kept[-1])
    assert set(trials["rig"]) == {"simulated"}
    assert trials["participant"].nunique() == 4
    assert not list(tmp_path.glob("data/.*"))


def test_page_states_applied_effect_and_inputs(alone):
    page = alone["power.html"].decode()
    assert "Simulated participants, no people (seed 5)." in page
    assert "<td>60</td><td>-4.00</td>" in page  # half of 8 dB below the middle
    assert "Take " in page or "No number that was tried" in page
    assert "&#34;seed&#34;: 5" in page
    assert page.count("<svg") == 1
    assert {"power.csv", "power.png", "power.svg", "asked.json", "study.toml"} <= set(alone)


def test_legend_is_below_the_axes(alone):
    texts = re.findall(r'<text[^>]* y="([0-9.]+)"[^>]*>([^<]+)<', alone["power.svg"].decode())
    places = {word: float(y) for y, word in texts}
    for label in ("target 0.8", "trials of the study", "significance level 0.05"):
        assert places[label] > places["Participants"]


def test_power_tables_are_marked_as_simulated(alone):
    assert pd.read_csv(io.BytesIO(alone["power.csv"]))["simulated"].all()
    batches = [content for name, content in alone.items() if name.startswith("studies")]
    assert all(parquet.read_schema(io.BytesIO(batch)).metadata[b"simulated"] == b"true" for batch in batches)


def test_other_inputs_do_not_resume_a_folder(capsys, tmp_path, alone):
    (tmp_path / "asked.json").write_bytes(alone["asked.json"])
    said = refused(capsys, *ASKED[:-1], "4", "--out", tmp_path, "--resume")
    assert "found most 3, expected 4 as requested; choose another --out" in said


def test_damaged_batch_is_refused_with_its_file(capsys, tmp_path, alone):
    restore(tmp_path, {name: content[: 100 if "effect" in name else None] for name, content in alone.items()})
    assert "expected a batch; remove it and use --resume" in refused(capsys, *ASKED, "--out", tmp_path, "--resume")


def test_bytes_do_not_depend_on_processes(capsys, tmp_path, alone):
    output(capsys, *ASKED, "--out", tmp_path, "--jobs", "2")
    assert files(tmp_path) == alone
