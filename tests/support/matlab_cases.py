"""Results of MATLAB psignifit and Palamedes in the shared folder."""

import json
from functools import cache

import numpy as np
import pytest
from places import SHARED

MATLAB = ("M_test1", "M_2AFC_norm", "M_2AFC_logistic", "M_YesNo_norm", "M_YesNo_logistic", "M_2AFC_gumbel")
MATLAB += ("M_YesNo_rgumbel",)
NAMES = {"norm": "normal", "rgumbel": "reversed_gumbel"}
FILE = SHARED / "data" / "psignifit_matlab_cases.json"


@cache
def cases() -> dict:
    return {case["id"]: case for case in json.loads(FILE.read_text())["cases"]}


def matlab_case(name: str) -> tuple[np.ndarray, dict, dict]:
    """Levels, correct answers and trials, options of `fit`, and the expected values."""
    if not FILE.exists():
        pytest.skip("the shared folder with psignifit's MATLAB cases is absent")
    case = cases()[name]
    options = {}
    if "sigmoid" in case:
        guess_rate = 0.5 if case["experiment_type"] == "2AFC" else None
        options = {"shape": NAMES.get(case["sigmoid"], case["sigmoid"]), "guess_rate": guess_rate}
    return np.array(case["data_level_correct_total"]).T, options, case["expected"]
