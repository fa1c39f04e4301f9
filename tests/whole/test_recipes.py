"""The extension recipes of CONTRIBUTING work in a copy of the tree."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT
from source_tree import copy_tree
from study_texts import TUTORIAL, changed
from tables import rows_of, trial_rows

NEW_FILES = ROOT / "tests" / "recipes"
HURRIED = """
def hurried(experiment: "Experiment", who: "Who", bench_file: "BenchFile") -> "RigKind":
    from tactometry.rigs.hurried import Hurried

    from .recording import RigKind

    return RigKind("hurried", lambda seed, log: Hurried())


"""
EN, FR = "tactometry/rigs/messages_en.toml", "tactometry/rigs/messages_fr.toml"
INSTRUCTIONS = 'instructions_oddity = """\n{}"""\n'
LINES = (
    (
        "experiments/study/kinds.py",
        '    "stochastic_approximation": ProcedureKind(\n'
        '        f"{_RULES}.stochastic_approximation:StochasticApproximation", '
        '{"start": 20.0, "step": 40.0, **_LEVELS}\n    ),\n',
        '    "staircase": ProcedureKind(',
    ),
    (
        "tactometry/trials/tasks.py",
        '    "oddity": TaskRows(INTERVAL, ("target", "standard_level"), "curve"),\n',
        '    "magnitude": TaskRows(',
    ),
    (
        EN,
        INSTRUCTIONS.format("Which is the odd one?\n\nThree touches, one unlike the others."),
        "instructions_yes_no = ",
    ),
    (EN, 'which_odd = "Which one was the odd one?"\n', "which_interval = "),
    (FR, INSTRUCTIONS.format("Lequel diffère ?\n\nTrois touchers, un seul diffère."), "instructions_yes_no = "),
    (FR, 'which_odd = "Lequel était différent ?"\n', "which_interval = "),
    ("tactometry/trials/columns.py", '    "hurried": "a hand in a hurry",\n', '    "simulated": '),
    ("experiments/accuracy/__init__.py", '    "series": f"{_HERE}.series:problem",\n', '    "spectral-sensitivity": '),
    ("experiments/sessions/rig_kinds.py", HURRIED, "def simulated("),
    ("tactometry/observers/kinds.py", '    "guesser": "tactometry.observers.guesser:Guesser",\n', "    USUAL: "),
    (
        "tactometry/devices/kinds.py",
        '    "ledger": "tactometry.devices.outputs.ledger:LedgerSettings",\n',
        '    "ni": ',
    ),
    (
        "tactometry/devices/kinds.py",
        '    "spring": "tactometry.devices.sensors.spring:SpringSettings",\n',
        '    "recorded": ',
    ),
    ("analysis/report/kinds.py", '    "latency",\n', '    "measured",\n'),
    (
        "stimuli/scenes/effects/__init__.py",
        '    "strips": "tactometry.stimuli.scenes.effects.strips:Strips",\n',
        '    "force_law": ',
    ),
)
"""File, added line, and the text after it."""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = copy_tree(tmp_path_factory.mktemp("tree"))
    for file in (file for file in NEW_FILES.rglob("*") if file.is_file() and "__pycache__" not in file.parts):
        new = place / file.relative_to(NEW_FILES)
        assert not new.exists()
        shutil.copy(file, new)
    for path, line, behind in LINES:
        text = (place / path).read_text(encoding="utf-8")
        assert text.count(behind) == 1
        (place / path).write_text(text.replace(behind, line + behind), encoding="utf-8")
    return place


STUDY = TUTORIAL.partition("\n[observer]")[0]
ODD_TASK = STUDY.replace('kind = "yes_no"\ncatch_rate = 0.2', 'kind = "oddity"\nstandard_level = 12.0')
ODD_LEVELS = ODD_TASK.replace("[60, 240]", "[240]").replace("[22, 28, 34, 40]", "[12.5, 14, 18, 26]")
ODD_STUDY = f"""{ODD_LEVELS.replace("repeats = 4", "repeats = 10")}
[observer]
between_sd_db = 0.0

[inquiries.surface]
form = "roughness"
"""
APPROXIMATION = """[procedure]
kind = "stochastic_approximation"
start = 25
step = 60
low = -10
high = 40

"""
APPROXIMATED_STUDY = f"{STUDY.partition('[procedure]')[0]}{APPROXIMATION}[limits]{STUDY.partition('[limits]')[2]}"
GUESSED_STUDY = f'{STUDY}\n[observer]\nkind = "guesser"\nbias = 0.9\n'
PRESS = '"press"\nforce_n = 1.0\nhold_s = 0.1\ntimeout_s = 20\n\n'
PRESSED_STUDY = changed(
    STUDY,
    {
        STUDY[STUDY.index('"slide"') : STUDY.index("[task]")]: PRESS,
        "catch_rate = 0.2": "",
        "[60, 240]": "[240]",
        '"500 ms"': "0.1",
        "[22, 28, 34, 40]": "[26]",
        "repeats = 4": "repeats = 2",
    },
)
BENCH = """
[output]
kind = "ledger"
path = "played.txt"

[sensors.hand]
kind = "spring"

[force]
sensor = "hand"
newtons_per_count = 1.0
release = false
measured_on = 2026-11-20
measured_by = "ZG"
"""
COVERED_SCENE = """
outputs = ["peak_force_n"]
surface = { kind = "electrovibration", frequency_hz = 60.0, duration_s = 0.2 }
given = { level_db_re_1v = 40.0 }

[[effects]]
kind = "force_law"
law = "sc_layer"

[[effects]]
kind = "strips"
share = 0.25
"""
COMMANDS = (
    "simulate odd.toml --participants 2 --seed 1 --out odd",
    "validate odd",
    "replay odd",
    "analyse odd --report odd.html",
    "simulate approximated.toml --participants 2 --seed 1 --out approximated",
    "validate approximated",
    "replay approximated",
    "analyse approximated --report approximated.html",
    "simulate guessed.toml --participants 1 --seed 1 --out guessed",
    "run odd_once.toml --participant P01 --rig console --out asked",
    "validate asked",
    "run odd_once.toml --participant P01 --rig hurried --out hurried",
    "validate hurried",
    "replay hurried",
    "run pressed.toml --participant P01 --rig console --bench bench.toml --out pressed",
    "validate pressed",
    "scene covered.toml --explain",
    "cost series --rounds 1 --out cost",
)
PROGRAM = """
import sys

sys.path.insert(0, sys.argv[1])
from tactometry.cli import main

for command in sys.argv[2:]:
    try:
        main(command.split())
    except SystemExit as ended:
        if ended.code:
            sys.exit(f"{command}: {ended.code}")
"""


@pytest.fixture(scope="module")
def folder(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("user")
    files = {"odd": ODD_STUDY, "odd_once": ODD_LEVELS, "approximated": APPROXIMATED_STUDY, "guessed": GUESSED_STUDY}
    files |= {"pressed": PRESSED_STUDY, "bench": BENCH, "covered": COVERED_SCENE}
    for name, text in files.items():
        (place / f"{name}.toml").write_text(text, encoding="utf-8")
    command = [sys.executable, "-W", "error", "-c", PROGRAM, str(tree), *COMMANDS]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, input="\n1" * 80, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (place / "said.txt").write_text(done.stdout, encoding="utf-8")
    return place


def test_task_is_added_by_two_files_and_line(folder: Path) -> None:
    rows = [row for row in trial_rows(folder / "odd") if row["task"] == "oddity" and row["valid"] == "1"]
    assert len(rows) == 2 * 4 * 10
    assert {row["target"] for row in rows} <= {"1", "2", "3"}
    assert {row["standard_level"] for row in rows} == {"12"}
    fitted = rows_of(folder / "odd_tables" / "thresholds.csv")
    assert {row["task"] for row in fitted} == {"oddity"}
    assert {row["guess_rate"][:6] for row in fitted} == {"0.3333"}
    asked = trial_rows(folder / "asked")
    assert len(asked) == 4 * 4
    assert {(row["task"], row["rig"], row["response"]) for row in asked} == {("oddity", "console", "1")}


@pytest.mark.parametrize(
    "said",
    [
        *(
            "reported which of three intervals was the odd one",
            "Detection threshold",
            "odd ones was 1/3",
            "Rate correct",
        ),
        *("Roughness of the surface", "<h2>Times to answer</h2>", "Median of all answers: "),
    ],
)
def test_report_contains_added_task_questionnaire_and_result(folder: Path, said: str) -> None:
    assert said in (folder / "odd.html").read_text(encoding="utf-8")


def test_questionnaire_is_added_by_file(folder: Path) -> None:
    rows = [row for row in trial_rows(folder / "odd") if row["procedure"] == "roughness"]
    assert [(row["task"], row["item"]) for row in rows] == [("rating", "rough")] * 2


def test_rig_is_added_by_file_function_and_line(folder: Path) -> None:
    rows = trial_rows(folder / "hurried")
    assert {(row["rig"], row["response"], row["latency_s"]) for row in rows} == {("hurried", "1", "0")}
    assert any("a hand in a hurry" in file.read_text("utf-8") for file in (folder / "hurried").glob("data/*.json"))


def test_procedure_is_added_by_file_and_line(folder: Path) -> None:
    assert {row["procedure"] for row in trial_rows(folder / "approximated")} == {"stochastic_approximation"}
    page = (folder / "approximated.html").read_text(encoding="utf-8")
    assert "Levels were chosen by stochastic approximation (first level 25 dB re 1 V" in page
    fitted = rows_of(folder / "approximated_tables" / "thresholds.csv")
    assert {row["rule_note"] for row in fitted} == {"last level at a chance of 0.6"}


def test_procedure_keys_are_derived_from_its_registration(tree: Path, folder: Path) -> None:
    (folder / "mistyped.toml").write_text(APPROXIMATED_STUDY.replace("step = 60", "stepp = 60"), encoding="utf-8")
    commands = "keys procedure.stochastic_approximation --json", "run mistyped.toml --participant P01 --dry-run"
    command = [sys.executable, "-W", "error", "-c", PROGRAM, str(tree), *commands]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    keys = {key["name"]: key["within"] for key in json.loads(done.stdout)[0]["keys"]}
    assert (list(keys)[1:], keys["target"]) == (["start", "step", "low", "high", "target", "n_trials"], "from 0 to 1")
    assert done.returncode == 1
    assert "procedure.stepp: found an unknown key" in done.stderr
    assert "did you mean 'step'" in done.stderr


def test_accuracy_problem_is_added_by_file_and_line(folder: Path) -> None:
    points = rows_of(folder / "cost" / "cost.csv")
    assert [point["setting"] for point in points] == ["1 terms", "10 terms", "100 terms", "1000 terms"]
    assert {point["problem"] for point in points} == {"series"}
    errors = [float(point["error"]) for point in points]
    assert errors == sorted(errors, reverse=True)
    assert (folder / "cost" / "series.png").stat().st_size > 10_000


def test_observer_is_added_by_file_and_line(folder: Path) -> None:
    [journal] = (folder / "guessed").glob("journals/*.jsonl")
    head = json.loads(journal.read_text(encoding="utf-8").splitlines()[0])
    assert "'kind': 'Guesser'" in str(head)


def test_sensor_and_output_are_added_by_file_and_line(folder: Path) -> None:
    rows = trial_rows(folder / "pressed")
    assert [(row["force_mean_n"], row["valid"]) for row in rows] == [("1", "1"), ("1", "1")]
    played = (folder / "played.txt").read_text(encoding="utf-8").splitlines()
    assert len(played) == 2
    for signal in played:
        peak_v, duration = signal.split(" V, ")
        assert duration == "0.10 s"
        assert 18.0 < float(peak_v) <= 10 ** (26 / 20)


def test_effect_is_added_by_file_and_line(folder: Path) -> None:
    said = (folder / "said.txt").read_text(encoding="utf-8")
    [row] = [line for line in said.splitlines() if line.startswith("strips")]
    assert row.split()[1:5] == ["on", "for", "force_law", "exact"]
    assert "share = 0.25" in said
    assert "strips are much narrower than the contact" in said
