"""Simulate participants, and print tables for docs/reference/analysis.md and docs/explanation/statistics.md.

    python benchmarks/bias_study.py STUDY [--n N] [--seed SEED] [--csv FILE]

| study | N | page |
|---|---|---|
| statuses, estimates | participants per setting | analysis.md, statuses and point estimates |
| comparisons, comparisons-equal, comparisons-without-lapses | data sets per row | analysis.md, comparisons |
| standards | studies per row | analysis.md, comparisons |
| groups | studies per row | analysis.md, hierarchical intervals; `--csv` continues an interrupted run |
| lapses | studies per row | statistics.md, lapses |
"""

from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tactometry.analysis.threshold.fitting import fit_many
from tactometry.experiments.bias_study import comparisons, estimates, groups, lapses, statuses
from tactometry.experiments.harness import table

Format = Callable[[Any], str]
PERCENT: Format = lambda value: "" if np.isnan(value) else f"{100 * value:.1f}"  # noqa: E731
RATE: Format = lambda value: f"{100 * value:g}"  # noqa: E731


def digits(form: str) -> Format:
    """Return a function that formats numbers. NaN becomes an empty text."""
    return lambda value: "" if np.isnan(value) else format(value, form)


def markdown(found: pd.DataFrame, columns: Mapping[str, tuple[str, Format]]) -> str:
    """Return a Markdown table, with a head and a format for each column."""
    rows = [[form(row[name]) for name, (_, form) in columns.items()] for row in found.to_dict("records")]
    return table([head for head, _ in columns.values()], rows)


STATUS_COLUMNS = {
    "n": ("tracks", str),
    "ok": ("`ok`", PERCENT),
    "separated": ("`separated`", PERCENT),
    "out": ("out of range", PERCENT),
    "flat": ("`flat`", PERCENT),
    "other": ("other", PERCENT),
    "covered": ("`ok` covered", PERCENT),
    "covered_all": ("all covered", PERCENT),
    "bias_sd": ("bias / SD", digits(".2f")),
    "length_db": ("length / dB", digits(".1f")),
}


def status_table(outcomes: pd.DataFrame, by: list[str]) -> str:
    """Return a table of operating characteristics for each group of outcomes."""
    keys = {name: (name.replace("_", " "), str) for name in by}
    return markdown(statuses.summary(outcomes, by), keys | STATUS_COLUMNS)


def of_statuses(n_sets: int, seed: int) -> str:
    """Return tables by place and number of trials. Places outside have 40 trials.

    Further tables for 40 trials inside the levels are by procedure and by task.
    """
    outcomes = pd.concat(statuses.outcomes_of(statuses.settings(), n_sets, np.random.default_rng(seed)))
    places = list(dict.fromkeys(outcomes["place"]))
    is_forty = outcomes["n_trials"] == 40
    shown = outcomes[is_forty | ~outcomes["place"].str.contains("below|above")]
    by_place = shown.sort_values("n_trials", kind="stable").sort_values(
        "place", kind="stable", key=lambda column: column.map(places.index)
    )
    inside = outcomes[(outcomes["place"] == "inside") & is_forty]
    others = [status_table(inside, [name]) for name in ("procedure", "task")]
    return "\n\n".join([status_table(by_place, ["place", "n_trials"]), *others])


def of_estimates(n_sets: int, seed: int) -> str:
    """Return a row for each design and lapse rate. Cells have values for a normal and a Gumbel truth."""
    outcomes = pd.concat(estimates.outcomes_of(n_sets, np.random.default_rng(seed)))
    result = estimates.summary(outcomes)
    forms = {"bias": digits("+.2f"), "covered": PERCENT, "length_db": digits(".1f"), "flat": PERCENT}
    rows = []
    for (design, lapse_rate), each in result.groupby(["design", "lapse_rate"], sort=False):
        cells = [", ".join(map(form, each.loc[each["fit"] == fit, name])) for name, form in forms.items()
                 for fit in estimates.FITS]  # fmt: skip
        rows.append([str(design), RATE(lapse_rate), *cells])
    names = ("bias before / SD", "covered before / %", "length before / dB", "`flat` before / %")
    heads = ("design", "lapses / %", *(head for name in names for head in (name, "now")))
    means = (
        result.assign(squared=result["bias"] ** 2).groupby("fit")[["squared", "covered", "length_db", "flat"]].mean()
    )
    return f"{table(heads, rows)}\n\n{means}"


def of_comparisons(n_sets: int, seed: int, **options: Any) -> str:
    """Return the coverage of JND and PSE for each simulated participant."""
    rng = np.random.default_rng(seed)
    fit = options or comparisons.FIT
    result = comparisons.summary(pd.concat(comparisons.outcomes_of(comparisons.PEOPLE, n_sets, rng, fit)))
    pse = result[result["quantity"] == "equality"]["covered"].to_numpy()
    differences = result[result["quantity"] == "difference"].assign(pse=pse)
    columns = {
        "sd": ("SD", digits("g")),
        "n_trials": ("trials per level", str),
        "lapse_rate": ("lapses / %", RATE),
        "covered": ("JND covered", PERCENT),
        "above": ("above", PERCENT),
        "below": ("below", PERCENT),
        "pse": ("PSE covered", PERCENT),
        "over_truth": ("JND / truth", digits(".2f")),
    }
    return markdown(differences, columns)


EQUAL_ASYMPTOTES = {**comparisons.FIT, "equal_asymptotes": True, "lapse_beta": 80.0}


def of_standards(n_studies: int, seed: int) -> str:
    """Return PSEs and false effects for standards near threshold, with equal and with free asymptotes."""
    columns = {
        "above_db": ("standard above threshold / dB", digits("g")),
        "rate": ("rate at lowest level", digits(".2f")),
        "error": ("PSE error / dB", digits("+.2f")),
        "sd": ("SD / dB", digits(".2f")),
        "covered": ("covered / %", PERCENT),
        "none": ("no PSE / %", PERCENT),
        "false_effects": ("false effects / %", PERCENT),
    }
    equal = comparisons.standards(n_studies, np.random.default_rng(seed), fit=fit_many, **EQUAL_ASYMPTOTES)
    free = comparisons.standards(n_studies, np.random.default_rng(seed))
    return f"Equal asymptotes:\n\n{markdown(equal, columns)}\n\nFree asymptotes:\n\n{markdown(free, columns)}"


def of_groups(n_studies: int, seed: int, csv: Path) -> str:
    """Return the coverage of hierarchical intervals, with standard errors."""
    done = int(pd.read_csv(csv)["study"].max()) + 1 if csv.exists() else 0
    for each in groups.outcomes_of(range(done, n_studies), seed):
        each.to_csv(csv, mode="a", header=not csv.exists(), index=False)
    result = groups.summary(pd.read_csv(csv))
    for kind in ("participants", "means", "contrast"):
        result[kind] = [
            f"{PERCENT(share)} ± {PERCENT(error)}" for share, error in result[[kind, f"se_{kind}"]].to_numpy()
        ]
    heads = {"participants": "participants", "means": "group means", "contrast": "contrast"}
    columns: dict[str, tuple[str, Format]] = {name: (name, str) for name in ("procedure", "lapses", "studies")}
    columns |= {name: (head, str) for name, head in heads.items()}
    columns |= {"error_db": ("mean error, dB", digits("+.2f")), "worst_db": ("worst mean, dB", digits("+.1f"))}
    return markdown(result, columns)


def of_lapses(n_studies: int, seed: int) -> str:
    """Return false effects due to lapses, by share of easy trials."""
    result = pd.DataFrame(lapses.outcomes_of(n_studies, np.random.default_rng(seed)))
    result["lapses"] = [f"{RATE(first)} and {RATE(second)}" for first, second in result[["first", "second"]].to_numpy()]
    columns = {
        "rule": ("rule", str),
        "lapses": ("lapses / %", str),
        "share": ("easy trials / %", RATE),
        "error": ("difference / dB", digits("+.2f")),
        "false_effects": ("false effects / %", PERCENT),
        "detected": ("lapses detected / %", PERCENT),
    }
    return markdown(result, columns)


STUDIES: dict[str, Callable[..., str]] = {
    "statuses": of_statuses,
    "estimates": of_estimates,
    "comparisons": of_comparisons,
    "comparisons-equal": partial(of_comparisons, **EQUAL_ASYMPTOTES),
    "comparisons-without-lapses": partial(of_comparisons, **comparisons.WITHOUT_LAPSES),
    "standards": of_standards,
    "groups": of_groups,
    "lapses": of_lapses,
}


def main() -> None:
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("--n", type=int, default=2, help="participants, data sets or studies")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, default=Path("groups.csv"), help="outcomes of groups")
    arguments = parser.parse_args()
    options = {"csv": arguments.csv} if arguments.study == "groups" else {}
    print(STUDIES[arguments.study](arguments.n, arguments.seed, **options))


if __name__ == "__main__":
    main()
