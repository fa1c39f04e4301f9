"""Models of the exported R script, fitted by R for each kind of task."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from command_line import output
from soak import SOAK

from tactometry.analysis.tasks.kinds import ANALYSES
from tactometry.experiments.data_sets.export import export
from tactometry.questionnaire import load

PACKAGES = ("lme4", "ordinal", "psyphy", "BradleyTerry2")
HEADER = (
    "participant,session,study,block,trial,side,procedure,level,level_unit,task,response,correct,valid,item,item_b,"
    "target,level_measured"
)
LINEAR = ("magnitude", "adjustment", "measurement", "nasa-tlx")
CLASSES = dict.fromkeys(LINEAR, "lmerMod") | {"preference": "BTm", "attrakdiff": "clmm"}


def has_packages() -> bool:
    if shutil.which("Rscript") is None:
        return False
    code = f"stopifnot({', '.join(f'requireNamespace({name!r}, quietly = TRUE)' for name in PACKAGES)})"
    return subprocess.run(["Rscript", "-e", code], capture_output=True, check=False).returncode == 0


def cells(task: str, rng: np.random.Generator, side: str, shift: float) -> list[object]:
    """Return a row from `level` on for a participant with threshold `shift`."""
    level = int(rng.integers(1, 8))
    chance = 1 / (1 + np.exp(-(level - 4 - shift - (side == "left"))))
    yes = int(rng.random() < chance)
    numbers = {"magnitude": np.exp(0.5 * level + rng.normal(0, 0.3)), "adjustment": 4 + shift + rng.normal()}
    target = int(rng.integers(1, 3))
    right = int(yes or rng.random() < 0.5)
    choice = target if right else 3 - target
    pair = rng.permutation(["P0", "P1", "P2"])[:2]
    response = {"forced_choice": choice, "localisation": choice, "preference": int(rng.integers(1, 3)), **numbers}
    response["measurement"] = 1000 + rng.integers(9)
    correct = right if task in ("forced_choice", "localisation") else ""
    measured = level - 1 + rng.normal() if task == "measurement" else ""
    items = pair if task == "preference" else ("", "")
    return [level, "dB", task, response.get(task, yes), correct, 1, *items, target, measured]


def table(path: Path, task: str) -> Path:
    rng = np.random.default_rng()
    lines = [HEADER]
    for person in range(1, 9):
        shift = rng.normal()
        for n in range(80):
            side = "left" if n % 2 else "right"
            row = [f"P{person}", 1, "made-up", 1, n + 1, side, "constant_stimuli", *cells(task, rng, side, shift)]
            lines.append(",".join(map(str, row)))
    file = path / "trials.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def answers(path: Path, name: str) -> Path:
    rng, form = np.random.default_rng(), load(name)
    values = np.linspace(form.low, form.high, form.steps or 101)
    lines = [HEADER]
    for person in range(1, 9):
        for n, side in enumerate(("left", "right"), 1):
            lines += [
                f"P{person},1,made-up,1,{n},{side},{name},,,rating,{rng.choice(values):g},,1,{item.id},,,"
                for item in form.items
            ]
    file = path / "trials.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def models(script: str) -> list[str]:
    return [line.removeprefix("# ") for line in script.splitlines() if re.match(r"# \w+::|# with\(", line)]


@pytest.mark.parametrize("task", sorted({*ANALYSES} - {"rating"}))
def test_r_script_has_the_model_of_each_task(tmp_path, task):
    export(table(tmp_path, task), "r", tmp_path / "r")
    (model,) = models((tmp_path / "r/trials.R").read_text())
    assert model.startswith(ANALYSES[task].r_model.split("(")[0])
    assert ("`side`" in model) is (task != "preference")


def test_r_export_states_alternatives_of_each_condition(tmp_path, capsys):
    header, *lines = table(tmp_path, "forced_choice").read_text().splitlines()
    rows = [f"{line},{4 if ',left,' in line else 2}" for line in lines]
    (tmp_path / "trials.csv").write_text("\n".join([f"{header},n_alternatives", *rows, ""]))
    output(capsys, "export", tmp_path / "trials.csv", "--to", "r", "--out", tmp_path / "r")
    found = models((tmp_path / "r/trials.R").read_text())
    assert [model.partition("mafc.probit(")[2][0] for model in found] == ["2", "4"]
    assert all(f'`side` == "{side}"' in model for side, model in zip(("right", "left"), found, strict=True))


@pytest.mark.parametrize(("form", "package"), [("attrakdiff", "ordinal::clmm("), ("nasa-tlx", "lme4::lmer(")])
def test_r_script_has_ordinal_or_linear_questionnaire_model(tmp_path, form, package):
    export(answers(tmp_path, form), "r", tmp_path / "r")
    (model,) = models((tmp_path / "r/trials.R").read_text())
    assert model.startswith(package)
    assert "glmer" not in model


@pytest.mark.soak
@pytest.mark.skipif(
    SOAK and not has_packages(), reason="needs r-cran-lme4 r-cran-ordinal r-cran-psyphy r-cran-bradleyterry2"
)
@pytest.mark.parametrize("task", [*sorted({*ANALYSES} - {"rating"}), "attrakdiff", "nasa-tlx"])
def test_r_fits_the_model(tmp_path, task):
    export(table(tmp_path, task) if task in ANALYSES else answers(tmp_path, task), "r", tmp_path / "r")
    script = (tmp_path / "r/trials.R").read_text()
    (model,) = models(script)
    (tmp_path / "r/tried.R").write_text(f"{script}\ncat(class(suppressWarnings({model})))\n")
    done = subprocess.run(["Rscript", "tried.R"], cwd=tmp_path / "r", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[0] == CLASSES.get(task, "glmerMod")


def test_r_script_reverses_answers_to_reversed_items(tmp_path):
    export(answers(tmp_path, "realism-likert"), "r", tmp_path / "r")
    script = (tmp_path / "r/trials.R").read_text()
    form = load("realism-likert")
    (turned,) = [item.id for item in form.items if item.reversed]
    assert f'ifelse(item %in% c("{turned}"), {form.low + form.high:g} - as.numeric(response)' in script
