"""psignifit and questplus as rungs of the ladders of fits and grids."""

import warnings
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tactometry.experiments.cost.problem import Rung
from tactometry.experiments.ladders import quest_plus_grid, threshold_fit
from tactometry.psychometric import shape_named

Real = NDArray[np.float64]
BINOMIAL = {"gamma": 0.5, "eta": 1e-9}
"""Its overdispersion is held at none, as in our fit."""
STEPS = {"default grid": {}, "80 x 60 x 40": {"threshold": 80, "width": 60, "lambda": 40}}


def threshold() -> list[Rung]:
    return [Rung(name, partial(_psignifit, steps), contender="psignifit") for name, steps in STEPS.items()]


def _psignifit(steps: dict[str, int]) -> Real:
    from psignifit import psignifit

    n = np.full(len(threshold_fit.LEVELS), threshold_fit.N_TRIALS)
    data = np.column_stack([threshold_fit.LEVELS, threshold_fit.N_CORRECT, n])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = psignifit(data, sigmoid="norm", experiment_type="2AFC", grid_steps=steps, fixed_parameters=BINOMIAL)
    low, high = found.confidence_intervals["threshold"]["0.95"]
    return np.array([found.parameter_estimate_mean["threshold"], low, high])


def quest_plus() -> list[Rung]:
    return [
        Rung(f"{n} x {quest_plus_grid.n_widths(n)}", partial(_questplus, n), contender="questplus")
        for n in quest_plus_grid.N_THRESHOLDS
    ]


def _questplus(n_thresholds: int) -> float:
    import questplus

    q = quest_plus_grid
    widths = np.array(q.middles(q.NARROW, q.WIDE, q.n_widths(n_thresholds)))
    levels = sorted({level for level, _ in q.ANSWERS})
    procedure = questplus.QuestPlus(
        stim_domain={"intensity": np.array(levels)},
        param_domain={
            "mean": np.array(q.middles(q.LOW, q.HIGH, n_thresholds)),
            "sd": widths / shape_named("normal").z_width,
            "lower_asymptote": np.array([0.5]),
            "lapse_rate": np.array([0.02]),
        },
        outcome_domain={"response": ["Yes", "No"]},
        func="norm_cdf",
        stim_scale="linear",
    )
    for level, response in q.ANSWERS:
        procedure.update(stim={"intensity": level}, outcome={"response": "Yes" if response else "No"})
    return float(procedure.param_estimate["mean"])
