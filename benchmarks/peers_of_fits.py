"""Settings of accuracy problems with psignifit and questplus."""

import warnings
from functools import partial

import numpy as np
from numpy.typing import NDArray

from tactometry.experiments.accuracy.measure import Setting
from tactometry.experiments.accuracy.problems import posteriors
from tactometry.psychometric import shape_named

BINOMIAL = {"gamma": 0.5, "eta": 1e-9}
"""Options without overdispersion, as in our fit."""
STEPS = {"default grid": {}, "80 x 60 x 40": {"threshold": 80, "width": 60, "lambda": 40}}


def threshold() -> list[Setting]:
    return [Setting(name, partial(_psignifit, steps), contender="psignifit") for name, steps in STEPS.items()]


def _psignifit(steps: dict[str, int]) -> NDArray[np.float64]:
    from psignifit import psignifit

    n = np.full(len(posteriors.LEVELS), posteriors.N_TRIALS)
    data = np.column_stack([posteriors.LEVELS, posteriors.N_CORRECT, n])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = psignifit(data, sigmoid="norm", experiment_type="2AFC", grid_steps=steps, fixed_parameters=BINOMIAL)
    low, high = result.confidence_intervals["threshold"]["0.95"]
    return np.array([result.parameter_estimate_mean["threshold"], low, high])


def quest_plus() -> list[Setting]:
    return [
        Setting(f"{n} x {posteriors.n_widths(n)}", partial(_questplus, n), contender="questplus")
        for n in posteriors.N_THRESHOLDS
    ]


def _questplus(n_thresholds: int) -> float:
    import questplus

    widths = np.array(posteriors.middles(posteriors.NARROW, posteriors.WIDE, posteriors.n_widths(n_thresholds)))
    means = np.array(posteriors.middles(posteriors.LOW, posteriors.HIGH, n_thresholds))
    rates = {"lower_asymptote": np.array([0.5]), "lapse_rate": np.array([0.02])}
    procedure = questplus.QuestPlus(
        stim_domain={"intensity": np.array(sorted({level for level, _ in posteriors.ANSWERS}))},
        param_domain={"mean": means, "sd": widths / shape_named("normal").z_width, **rates},
        outcome_domain={"response": ["Yes", "No"]},
        func="norm_cdf",
        stim_scale="linear",
    )
    for level, response in posteriors.ANSWERS:
        procedure.update(stim={"intensity": level}, outcome={"response": "Yes" if response else "No"})
    return float(procedure.param_estimate["mean"])
