"""Studies to simulate, which have the stated effect and no other."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final

import numpy as np

from tactometry.analysis.outcomes.ratings import PATTERN, REFERENCE
from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.tasks.kinds import ANALYSES
from tactometry.arguments.require import expect, one_of
from tactometry.config.strict import build
from tactometry.config.toml import merge
from tactometry.errors import rewording
from tactometry.observers.kinds import USUAL
from tactometry.observers.people import Stated, Varied
from tactometry.trials.cells import cell as cell_text
from tactometry.trials.tasks import FORM_TASK

from ..study.cells import WiredCell
from ..study.experiment import Experiment, wire
from ..study.predictions import contact_of, felt_db
from ..study.session_plan import places_of
from ..study.study import Study
from ..study.study_file import parse
from . import level_map
from .design import Case, PowerDesign
from .effect import OF_EXPONENT, OF_JND, OF_PSE, OF_SCORE, OF_SENSATION, StatedEffect, check_effect
from .level_map import LevelMap
from .scores import applied_effect, factors_of, form_of_task, has_patterns, with_attitudes

SUPPORTED: Final = ("yes_no", "forced_choice", "adjustment", "localisation", "rating", *level_map.TASKS)
REFUSED: Final = {
    "same_different": "its analysis estimates d' at each level and tests no value per participant and condition",
    "preference": "its analysis compares answers within trials and tests no value per participant and condition",
    "measurement": "its levels are sensor readings, not sensations of a participant",
}
STEP_SHARE: Final = 0.05
"""Step for computing the growth of sensation, as a share of the range of the levels."""


def experiment_of(design: PowerDesign, case: Case) -> Experiment:
    """Return the wired study of a case, cached."""
    return _wired(design, case)[0]


def maps_of(design: PowerDesign, case: Case) -> dict[str, LevelMap]:
    """Return the level map at each level of the effect's factor, or {}."""
    return _wired(design, case)[1]


@lru_cache(maxsize=8)
def _wired(design: PowerDesign, case: Case) -> tuple[Experiment, dict[str, LevelMap]]:
    study = with_trials(parse(design.study_toml, design.where), case.n_trials)
    base = wire(study, design.where, design.code_from)
    effect = applied_effect(design.effect, study)
    is_felt = case.has_effect and not (effect.is_of_score or effect.moves_levels)
    shifts_db, maps = shifts(base, effect, has_effect=is_felt), {}
    if effect.moves_levels:
        slopes = level_map.slopes_of(base, effect.factor, growths(base, effect.factor)[1])
        maps = level_map.level_maps(base, effect, slopes, has_effect=case.has_effect)
        study = level_map.with_levels(study, effect.factor, maps)
    study = with_shifts(study, effect.factor, shifts_db)
    if effect.is_of_score:
        study = with_attitudes(study, effect, base, design.dependent, float(case.has_effect))
    return wire(study, design.where, design.code_from), maps


def plan_of_study(study: Study) -> AnalysisPlan:
    """Return the analysis plan without the hierarchical fit (it has no test)."""
    return replace(build(AnalysisPlan, study.analysis, "analysis"), hierarchical=False)


def check_design(design: PowerDesign) -> str:
    """Check that a design can be simulated, and return its dependent variable.

    Raises `InvalidParameter` if the study cannot have the effect or the trials, or its task has no power analysis.
    """
    study = parse(design.study_toml, design.where)
    check_effect(design.effect, factors_of(study))
    dependent = _dependent(design, study)
    for case in design.cases:
        experiment_of(replace(design, dependent=dependent), case)
    return dependent


def _dependent(design: PowerDesign, study: Study) -> str:
    experiment = wire(study, design.where, design.code_from)
    with rewording(lambda words: f"{design.where}, {words}"):
        _check_people(experiment)
    task = experiment.table.kind
    why = REFUSED.get(task, "the effect of a factor on it is not defined")
    expect(task in SUPPORTED, f"{design.where}, task.kind", f"{task!r}", f"one of {', '.join(SUPPORTED)}: {why}")
    found = f"the factor {design.effect.factor!r}, whose levels are the alternatives of a trial"
    expect(experiment.table.over != design.effect.factor, "--effect", found, "another factor")
    _check_places(experiment, applied_effect(design.effect, study).factor)
    known = _check_scores(design, experiment) if task == FORM_TASK else _check_levels(design, experiment)
    if design.dependent:
        one_of("--dependent", design.dependent, known)
    first = "jnd" if design.effect.unit == OF_JND else known[0]
    return design.dependent or first


def _check_levels(design: PowerDesign, experiment: Experiment) -> tuple[str, ...]:
    """Check the effect's unit, and return the dependent variables of the task."""
    units = {cell.condition.level_unit.partition(" re ")[0] for cell in experiment.cells.values()}
    if experiment.table.kind in level_map.TASKS:
        return _check_moved_levels(design, experiment, units)
    felt = () if isinstance(experiment.people.middle, Stated) else (OF_SENSATION,)  # stated thresholds: no sensation
    allowed = sorted({*felt, *(units if len(units) == 1 else ())})
    one = f"one of {', '.join(allowed)}: the unit of the levels, or of sensation ({OF_SENSATION})"
    expect(design.effect.unit in allowed, "--effect", f"the unit {design.effect.unit!r}", one)
    return tuple(ANALYSES[experiment.table.kind].dependents)


def _check_moved_levels(design: PowerDesign, experiment: Experiment, units: set[str]) -> tuple[str, ...]:
    """Check the unit in a comparison or magnitude task. Returns dependents."""
    kind, (unit, *others) = experiment.table.kind, sorted(units)
    of_pse = () if others else (f"{unit}{OF_PSE}",)
    allowed = (*of_pse, OF_JND) if kind == "comparison" else (OF_EXPONENT,)
    example = f"such as '{design.effect.factor}: 20 {allowed[-1]}'"
    one = f"one of {', '.join(allowed)}, {example}"
    expect(design.effect.unit in allowed, "--effect", f"the unit {design.effect.unit!r} of a {kind}", one)
    level_map.check_maps(experiment.study, design.effect.factor)
    return tuple(ANALYSES[kind].dependents)


def _check_scores(design: PowerDesign, experiment: Experiment) -> tuple[str, ...]:
    """Check the effect, and return the dimensions of the questionnaire."""
    form = form_of_task(experiment)
    assert form is not None
    with rewording(lambda words: f"{design.where}, {words}"):
        has_attitudes = experiment.people.raters is not None
        expected = "the table [observer.raters], as an effect on a score changes attitudes"
        expect(has_attitudes, "observer.raters", "none", expected)
    one = f"{OF_SCORE}, the unit of scores (dimensions for --dependent: {', '.join(form.dimensions)})"
    expect(design.effect.is_of_score, "--effect", f"the unit {design.effect.unit!r}", one)
    has_test = design.effect.factor != PATTERN or not has_patterns(experiment.study)
    levels = map(str, experiment.study.factors.get(PATTERN, ()))
    with_reference = f"frequency or envelope, as single patterns are only tested against {REFERENCE}"
    expect(has_test or REFERENCE in levels, "--effect", f"the factor {PATTERN!r}", with_reference)
    return tuple(form.dimensions)


def _check_places(experiment: Experiment, factor: str) -> None:
    """Reject a factor that changes the places of a localisation task.

    The rates of such a task depend on the distance between places.
    """
    rows = ((cell.condition.factors[factor], places_of(cell.stimulus)) for cell in experiment.cells.values())
    by_level: dict[float | str, set[Any]] = {}
    for level, places in rows:
        by_level.setdefault(level, set()).add(places)
    are_alike = len({frozenset(places) for places in by_level.values()}) == 1
    moves = f"the factor {factor!r}, whose levels have different places"
    expect(are_alike, "--effect", moves, "a factor with the same places at all levels")


def _check_people(experiment: Experiment) -> None:
    """Reject simulated participants without traits, or with code not allowed."""
    experiment.people.check_allowed()
    kind = experiment.study.observer.get("kind", USUAL)
    has_traits = isinstance(experiment.people.middle, Varied)
    expect(
        has_traits, "observer.kind", f"{kind!r}, which does not accept [observer.people]", "a class with person(traits)"
    )


def with_trials(study: Study, n_trials: int | None) -> Study:
    """Return the study with a number of trials in each track.

    For an adaptive rule, this is the largest number. The rule may end earlier.

    Raises `InvalidParameter` if the procedure has no number of trials.
    """
    if n_trials is None:
        return study
    changes = {
        factor: {level: _tables_with_trials(study, tables, n_trials) for level, tables in of_levels.items()}
        for factor, of_levels in study.variants.items()
    }
    levels_vary = "levels" not in study.procedure and study.procedure.get("kind") == "constant_stimuli"
    procedure = study.procedure if levels_vary else merge(study.procedure, _trials_keys(study.procedure, n_trials))
    return replace(study, procedure=procedure, variants=changes)


def _tables_with_trials(study: Study, tables: Mapping[str, Any], n_trials: int) -> dict[str, dict[str, Any]]:
    own = tables.get("procedure")
    if own is None:
        return dict(tables)
    return {**tables, "procedure": merge(own, _trials_keys(merge(study.procedure, own), n_trials))}


def _trials_keys(procedure: Mapping[str, Any], n_trials: int) -> dict[str, int]:
    kind, levels = procedure.get("kind"), procedure.get("levels", ())
    limits = "n_series, as this method has no number of trials; change the study"
    expect(kind != "method_of_limits", "--trials", f"{n_trials} with the method of limits", f"a study file's {limits}")
    if kind != "constant_stimuli":
        return {"n_trials": n_trials}
    whole = n_trials % max(len(levels), 1) == 0
    expect(whole, "--trials", f"{n_trials} with {len(levels)} constant levels", "a multiple of the number of levels")
    return {"repeats": n_trials // max(len(levels), 1)}


def shifts(experiment: Experiment, effect: StatedEffect, *, has_effect: bool) -> dict[str, float]:
    """Return the change in sensation level (dB) at each level of a factor.

    The changes make all levels of the factor feel alike in the middle of the played levels (or at the standard), and
    add the effect.
    """
    middle_db, slopes = growths(experiment, effect.factor)
    for level, db in middle_db.items():
        found = f"no sensation at {effect.factor} {level} in the middle of the levels"
        expect(np.isfinite(db) and slopes[level] > 0, "--effect", found, "a sensation that grows with the level")
    common_db = float(np.mean(list(middle_db.values())))
    changes = effect.of_levels(experiment.study.factors[effect.factor])
    effects_db = {level: changes[level] if effect.is_felt else -slopes[level] * changes[level] for level in middle_db}
    return {level: common_db - middle_db[level] + (effects_db[level] if has_effect else 0.0) for level in middle_db}


def growths(experiment: Experiment, factor: str) -> tuple[dict[str, float], dict[str, float]]:
    """Return the means of `growth` over the cells of each level of a factor."""
    felt: dict[str, list[tuple[float, float]]] = {cell_text(level): [] for level in experiment.study.factors[factor]}
    for cell in experiment.cells.values():
        felt[cell_text(cell.condition.factors[factor])].append(growth(experiment, cell))
    middle_db = {level: float(np.mean([db for db, _ in of_level])) for level, of_level in felt.items()}
    return middle_db, {level: float(np.mean([slope for _, slope in of_level])) for level, of_level in felt.items()}


def growth(experiment: Experiment, cell: WiredCell) -> tuple[float, float]:
    """Return a cell's sensation level (dB) and its slope per level unit.

    Both are computed in the middle of the levels, or at the standard, for the requested touch. With stated thresholds,
    the first value is the distance above threshold in the unit of the level.
    """
    middle, people = float(getattr(experiment.task, "standard_level", middle_of(cell))), experiment.people.middle
    if isinstance(people, Stated):
        return middle - (people.stated(cell.condition.factors).threshold or 0.0), 1.0
    low, high = cell.procedure.rule.bounds
    step, met = max(STEP_SHARE * (high - low), 1e-3), contact_of(cell)
    below_db, at_db, above_db = (felt_db(cell, level, met) for level in (middle - step, middle, middle + step))
    return at_db, (above_db - below_db) / (2 * step)


def middle_of(cell: WiredCell) -> float:
    """Return the middle of the levels of a cell."""
    low, high = cell.procedure.rule.bounds
    return (low + high) / 2


def with_shifts(study: Study, factor: str, shifts_db: Mapping[str, float]) -> Study:
    """Return a study whose participants feel shifts at a factor's levels."""
    people = study.observer.get("people", {})
    effects_db = {**people.get("effects_db", {}), factor: dict(shifts_db)}
    return replace(study, observer={**study.observer, "people": {**people, "effects_db": effects_db}})


def felt_more(study: Study, factor: str) -> dict[str, float]:
    """Return the shift of `with_shifts` at each level, dB."""
    of_level: dict[str, float] = study.observer["people"]["effects_db"][factor]
    return of_level
