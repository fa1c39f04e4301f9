"""A procedure is added as CONTRIBUTING says, one file and one line, and a study runs with it to its report."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from command_line import call

from tactometry.arguments.require import finite, within
from tactometry.experiments.study.key_tables import procedure_tables
from tactometry.experiments.study.keys import keys_of
from tactometry.experiments.study.procedure_table import PROCEDURES, ProcedureKind
from tactometry.experiments.study.study_file import load
from tactometry.protocols.procedures.procedure import Ending, Rule, RuleThreshold, Run

# The file, as it would stand in protocols/procedures/stochastic_approximation.py.


@dataclass(frozen=True)
class StochasticApproximation(Rule["StochasticApproximationRun"]):
    """The level falls by step / n times (response - target). Robbins and Monro, Ann. Math. Stat. 22, 400 (1951)."""

    start: float
    step: float
    low: float
    high: float
    target: float = 0.6
    n_trials: int = 30

    name: ClassVar[str] = "stochastic_approximation"

    def __post_init__(self) -> None:
        finite("StochasticApproximation", start=self.start, step=self.step, low=self.low, high=self.high)
        within("StochasticApproximation", 0, 1, target=self.target)

    @property
    def bounds(self) -> tuple[float, float]:
        return self.low, self.high

    @property
    def n_trials_at_most(self) -> int:
        return self.n_trials

    def begin(self, rng: np.random.Generator | None = None) -> "StochasticApproximationRun":
        del rng
        return StochasticApproximationRun(self, asked=self.start)


@dataclass(frozen=True)
class StochasticApproximationRun(Run[StochasticApproximation]):
    asked: float = 0.0

    @property
    def level(self) -> float:
        return self.asked

    @property
    def ended(self) -> Ending | None:
        return "trials" if len(self.responses) >= self.rule.n_trials else None

    def _updated(self) -> "StochasticApproximationRun":
        n, away = len(self.responses), self.responses[-1] - self.rule.target
        wanted = self.delivered[-1] - self.rule.step / n * away
        return replace(self, asked=min(max(wanted, self.rule.low), self.rule.high))

    def _estimate(self) -> RuleThreshold:
        return RuleThreshold(self.asked, n=len(self.responses), note=f"last level at a chance of {self.rule.target:g}")


@pytest.fixture
def added(monkeypatch):
    """The line in `experiments/study/procedure_table.py`."""
    example = {"start": 20.0, "step": 40.0, "low": 0.0, "high": 40.0}
    line = ProcedureKind(StochasticApproximation, example)
    monkeypatch.setitem(PROCEDURES, "stochastic_approximation", line)


TABLE = '[procedure]\nkind = "stochastic_approximation"\nstart = 25\nstep = 60\nlow = -10\nhigh = 40\n\n'


def a_study(tmp_path, table=TABLE):
    text = load("tutorial")[1].decode()
    path = tmp_path / "s.toml"
    path.write_text(f"{text.partition('[procedure]')[0]}{table}[limits]{text.partition('[limits]')[2]}")
    return path


@pytest.mark.usefixtures("added")
def test_a_study_runs_with_it_to_its_report(tmp_path, capsys):
    study, data, report = a_study(tmp_path), tmp_path / "d", tmp_path / "r.html"
    assert call(capsys, "simulate", study, "--participants", 2, "--seed", 1, "--out", data)[0] == 0
    for command in (("validate", data), ("replay", data), ("analyse", data, "--report", report)):
        status, said, _ = call(capsys, *command)
        assert status == 0, said
    table = next(data.glob("data/*.csv")).read_text()
    assert ",stochastic_approximation," in table
    page = report.read_text()
    assert "Levels were chosen by stochastic approximation" in page
    assert "last level at a chance of 0.6" in (tmp_path / "r_tables" / "thresholds.csv").read_text()


@pytest.mark.usefixtures("added")
def test_the_page_of_keys_has_it():
    table = dict(procedure_tables())['`kind = "stochastic_approximation"`']
    within_range = {key.name: key.within for key in keys_of(table)}
    assert within_range == dict.fromkeys(("start", "step", "low", "high", "n_trials"), "") | {"target": "from 0 to 1"}


@pytest.mark.usefixtures("added")
def test_a_mistyped_key_of_it_is_named(tmp_path, capsys):
    study = a_study(tmp_path, TABLE.replace("step", "stepp"))
    status, said, _ = call(capsys, "run", study, "--participant", "P01", "--dry-run")
    assert status == 2
    assert "procedure.stepp: found an unknown key" in said
    assert "did you mean 'step'" in said
