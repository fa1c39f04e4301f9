"""Custom observers, whose code runs only where a user allowed it."""

import subprocess
import sys
from dataclasses import dataclass

import pytest
from command_line import call, output, refused
from places import ROOT
from study_texts import TUTORIAL
from tables import contents, trial_rows

from tactometry.errors import Terminated
from tactometry.user_code import guarded

GUESSER = (ROOT / "tests" / "recipes" / "tactometry" / "observers" / "guesser.py").read_text("utf-8")
CODE = GUESSER.replace("from ..arguments", "from tactometry.arguments").replace(
    "import numpy as np\n", "import numpy as np\nfrom beside import BIAS\n"
)
STUDY = TUTORIAL.partition("\n[observer]")[0]
OWN = f'{STUDY}\n[observer]\nkind = "mine:Guesser"\nbias = 0.9\n'
ALL = ("--participants", "3", "--seed", "4")


@pytest.fixture
def study(tmp_path):
    """Return a study with a custom observer that imports a module next to it."""
    place = tmp_path / "studies"
    place.mkdir()
    (place / "mine.py").write_text(CODE)
    (place / "beside.py").write_text("BIAS = 0.5\n")
    (place / "own.toml").write_text(OWN)
    return place / "own.toml"


def test_own_observer_answers_when_allowed(study, tmp_path, capsys):
    output(capsys, "simulate", study, *ALL, "--out", tmp_path / "d", "--allow-code")
    answers = [float(row["response"]) for row in trial_rows(tmp_path / "d") if row["response"]]
    assert len(answers) > 90
    assert 0.75 < sum(answers) / len(answers) < 1.0  # 0.9, 0.03 of standard error


def test_own_observer_does_not_run_without_permission(study, tmp_path, capsys):
    session = ("run", study, "--participant", "P01", "--seed", "4", "--rig")
    output(capsys, *session, "simulated", "--out", tmp_path / "allowed", "--allow-code")
    (study.parent / "mine.py").write_text("raise SystemExit('it ran')\n")
    for words in (("simulate", study, *ALL), (*session, "simulated")):
        said = refused(capsys, *words, "--out", tmp_path / "d")
        assert "observer.kind: found 'mine:Guesser', an observer whose code would run, expected --allow-code" in said
    assert not (tmp_path / "d").exists()
    output(capsys, *session, "console", "--dry-run", "--allow-code")


def test_own_observer_data_are_read_without_code(study, tmp_path, capsys):
    root = tmp_path / "d"
    output(capsys, "simulate", study, *ALL, "--out", root, "--allow-code")
    (study.parent / "mine.py").unlink()
    for words in (("validate", root), ("replay", root), ("analyse", root, "--report", tmp_path / "report.html")):
        assert call(capsys, *words)[0] == 0
    assert "simulated participants" in (tmp_path / "report.html").read_text("utf-8").lower()
    (journal, *_) = sorted(root.glob("journals/*"))
    head = journal.read_text("utf-8").partition("\n")[0]
    assert '"Guesser"' in head
    assert '"bias":0.9' in head


def test_any_number_of_workers_gives_the_same_bytes(study, tmp_path, capsys, monkeypatch):
    output(capsys, "simulate", study, *ALL, "--out", tmp_path / "one", "--allow-code")
    monkeypatch.chdir(study.parent)
    output(capsys, "simulate", "own.toml", *ALL, "--out", tmp_path / "two", "--allow-code", "--jobs", "2")
    assert contents(tmp_path / "two") == contents(tmp_path / "one")


@pytest.mark.slow
def test_cluster_finds_own_observer_by_study_path(study, tmp_path, capsys):
    pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
    output(capsys, "simulate", study, *ALL, "--out", tmp_path / "one", "--allow-code")
    (tmp_path / "cluster.py").write_text(
        "import sys\n"
        "import distributed\n"
        "from tactometry.cli import main\n"
        "if __name__ == '__main__':\n"
        "    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:\n"
        "        main([*sys.argv[1:], '--scheduler', cluster.scheduler_address])\n"
    )
    words = ["simulate", "own.toml", *ALL, "--out", str(tmp_path / "two"), "--allow-code"]
    program = [sys.executable, str(tmp_path / "cluster.py"), *words]
    done = subprocess.run(program, capture_output=True, text=True, check=False, cwd=study.parent)
    assert done.returncode == 0, done.stderr
    assert contents(tmp_path / "two") == contents(tmp_path / "one")


LACKING = "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass Guesser:\n    bias: float\n"


@pytest.mark.parametrize(
    ("kind", "code", "sentence"),
    [
        ("mine:Guesser", None, "but no file mine.py in"),
        ("mine:Guesser", "1 / 0\n", "mine.py, line 1 (ZeroDivisionError: division by zero), expected a module that"),
        ("mine:Guesser", "raise SystemExit(0)\n", "mine.py, line 1 (SystemExit: 0), expected a module that can be"),
        ("mine:Guesser", "Guesser = 3\n", "no dataclass 'Guesser' in mine.py"),
        ("mine:Guesser", LACKING, "which lacks participant, detect, compare"),
        ("mine:Guesser", CODE.replace("bias: float", "slope: float"), "observer.bias: found an unknown key"),
        ("../mine:Guesser", CODE, "expected module:Class"),
    ],
)
def test_flawed_own_observer_is_refused(study, tmp_path, capsys, kind, code, sentence):
    study.write_text(OWN.replace("mine:Guesser", kind))
    (study.parent / "mine.py").unlink() if code is None else (study.parent / "mine.py").write_text(code)
    said = refused(capsys, "simulate", study, *ALL, "--out", tmp_path / "d", "--allow-code")
    assert sentence in said
    assert not (tmp_path / "d").exists()


WRONG = [
    ("detect", "return 1 / 0", "found ZeroDivisionError (division by zero) in detect, expected an answer"),
    ("detect", "return 'maybe'", "found 'maybe' as the answer of detect, expected True or False"),
    ("answer_time_s", "return float('nan')", "found nan as the answer of answer_time_s, expected a finite number"),
    ("facts", "return {'levels': [1]}", "expected a dictionary of texts and numbers"),
    ("participant", "return None", "found None as the answer of participant, expected an observer"),
    ("detect", "raise SystemExit(0)", "found SystemExit (0) in detect, expected an answer"),
    ("detect", "raise SystemExit(143)", "found SystemExit (143) in detect, expected an answer"),
    ("detect", "raise GeneratorExit", "found GeneratorExit () in detect, expected an answer"),
    ("detect", "raise type('Mine', (KeyboardInterrupt,), {})", "found Mine () in detect, expected an answer"),
    ("facts", "raise SystemExit", "found SystemExit () in facts, expected an answer"),
    ("__post_init__", "raise KeyError('no such table')", "found KeyError ('no such table') in __post_init__"),
]


def with_body(method, body):
    """Insert a first line in a method; return code and both line numbers."""
    lines = CODE.splitlines()
    begin = next(n for n, line in enumerate(lines) if f"def {method}(" in line)
    lines.insert(begin + 1, f"        {body}")
    return "\n".join(lines), (begin + 1, begin + 2)


@pytest.mark.parametrize(("method", "body", "sentence"), WRONG)
def test_errors_of_own_observer_name_file_and_line(study, tmp_path, capsys, method, body, sentence):
    code, numbers = with_body(method, body)
    (study.parent / "mine.py").write_text(code)
    said = refused(capsys, "simulate", study, *ALL, "--out", tmp_path / "d", "--allow-code")
    assert sentence in said
    assert any(f"{study.parent / 'mine.py'}, line {number}: " in said for number in numbers)


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("next(LEFT)", "found StopIteration () in detect"),
        ("next(LEFT, None) is None and exit(0)", "found SystemExit (0) in detect"),
    ],
)
def test_session_continues_after_own_observer_failed(study, tmp_path, capsys, body, sentence):
    """The observer fails for the second of three participants.

    Once it is corrected, the resumed data set equals an uninterrupted one.
    """
    output(capsys, "simulate", study, *ALL, "--out", tmp_path / "whole", "--allow-code")
    (study.parent / "beside.py").write_text("BIAS, LEFT = 0.5, iter(range(70))\n")
    failing = with_body("detect", body)[0].replace("import BIAS", "import BIAS, LEFT")
    (study.parent / "mine.py").write_text(failing)
    words = ("simulate", study, *ALL, "--out", tmp_path / "d", "--allow-code")
    said = refused(capsys, *words)
    assert sentence in said
    assert 70 <= len(trial_rows(tmp_path / "d")) < len(trial_rows(tmp_path / "whole"))
    (study.parent / "mine.py").write_text(CODE)
    output(capsys, *words, "--resume")
    assert trial_rows(tmp_path / "d") == trial_rows(tmp_path / "whole")
    assert call(capsys, "validate", tmp_path / "d")[0] == 0


def test_participant_of_other_class_is_guarded(study, tmp_path, capsys):
    (study.parent / "mine.py").write_text(
        CODE.replace("return self\n", "return Person(self.bias)\n")
        + "\n\n@dataclass(frozen=True, slots=True)\nclass Person(Guesser):\n"
        "    def detect(self, sensation_db, rng):\n        return self.nothing\n"
    )
    said = refused(capsys, "simulate", study, *ALL, "--out", tmp_path / "d", "--allow-code")
    assert "found AttributeError ('Person' object has no attribute 'nothing') in detect" in said


@pytest.mark.parametrize("end", [KeyboardInterrupt(), Terminated(143)], ids=repr)
def test_signals_that_arrive_in_own_code_pass(end):
    kind = guarded(Interrupted, {"detect": None})
    with pytest.raises(type(end)) as raised:
        kind(end).detect()
    assert raised.value is end


@dataclass(frozen=True)
class Interrupted:
    end: BaseException

    def detect(self):
        raise self.end
