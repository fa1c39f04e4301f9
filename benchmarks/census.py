"""The tables of docs/reference/analysis.md on statuses, and on point estimates and intervals.

`python benchmarks/census.py --sets 20 --seed 1 --csv outcomes.csv`
`python benchmarks/census.py --estimates 200 --seed 1`

`--from outcomes.csv` makes the tables of statuses of outcomes kept before.
"""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np
import pandas as pd

from tactometry.experiments.census import estimates
from tactometry.experiments.census.thresholds import census, settings, summary

SHARES = {
    "ok": "`ok`",
    "separated": "`separated`",
    "out": "out of range",
    "flat": "`flat`",
    "other": "other",
    "covered": "`ok` covered",
    "covered_all": "all covered",
}
N_TRIALS = 40
"""Number of trials at which thresholds outside of the levels, and single procedures and tasks, are shown."""


def table(outcomes: pd.DataFrame, by: list[str]) -> str:
    """As Markdown, shares in per cent."""
    heads = [*(name.replace("_", " ") for name in by), "tracks", *SHARES.values(), "bias / SD", "length / dB"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for row in summary(outcomes, by).itertuples(index=False):
        cells = [str(getattr(row, name)) for name in by] + [str(row.n)]
        cells += [_number(100 * getattr(row, name), 1) for name in SHARES]
        lines.append("| " + " | ".join([*cells, _number(row.bias_sd, 2), _number(row.length_db, 1)]) + " |")
    return "\n".join(lines)


def tables(outcomes: pd.DataFrame) -> str:
    """Return the tables by place and number of trials, and by procedure and by task for thresholds inside."""
    is_shown_n = outcomes["n_trials"] == N_TRIALS
    shown = outcomes[is_shown_n | ~outcomes["place"].str.contains("below|above")]
    by_place = shown.sort_values("n_trials", kind="stable").sort_values("place", kind="stable", key=_order(outcomes))

    inside = outcomes[(outcomes["place"] == "inside") & is_shown_n]
    each = (table(by_place, ["place", "n_trials"]), *(table(inside, [name]) for name in ("procedure", "task")))
    return "\n\n".join(each)


def _order(outcomes: pd.DataFrame):  # type: ignore[no-untyped-def]
    """Places in the order in which they come."""
    places = list(dict.fromkeys(outcomes["place"]))
    return lambda column: column.map(places.index)


ESTIMATE_HEADS = (
    *("design", "lapses / %", "bias before / SD", "now", "covered before / %", "now"),
    *("length before / dB", "now", "`flat` before / %", "now"),
)


def estimate_table(found: pd.DataFrame) -> str:
    """As Markdown: a row for each design and lapse rate, in each cell the normal and the Gumbel truth."""
    lines = ["| " + " | ".join(ESTIMATE_HEADS) + " |", "|" + "---|" * len(ESTIMATE_HEADS)]
    for (design, lapse_rate), rows in found.groupby(["design", "lapse_rate"], sort=False):
        cells = [str(design), f"{100 * lapse_rate:g}"]  # type: ignore[operator]
        for name, form in (("bias", "{:+.2f}"), ("covered", "{:.1f}"), ("length_db", "{:.1f}"), ("flat", "{:.1f}")):
            scale = 100 if name in ("covered", "flat") else 1
            cells += [", ".join(map(form.format, scale * rows.loc[rows["fit"] == fit, name])) for fit in estimates.FITS]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def print_estimates(n_sets: int, seed: int) -> None:
    """Print the table of estimates, and how many rows reach the goals."""
    outcomes = pd.concat(estimates.census(n_sets, np.random.default_rng(seed)))
    found = estimates.summary(outcomes)
    print(estimate_table(found))
    goal = np.where(found["design"].str.contains("6 x"), 0.1, 0.25)
    is_forced = found["design"].isin([design.name for design in estimates.DESIGNS if design.task.told])
    found = found.assign(
        goal=found["bias"].abs() < goal, held=found["covered"].between(0.935, 0.97), squared=found["bias"] ** 2
    )
    print(found.groupby([is_forced, "fit"], sort=False)[["goal", "held"]].sum())
    print(
        found.groupby([is_forced, "fit"], sort=False)[["squared", "covered", "covered_all", "length_db", "flat"]].mean()
    )
    flat = outcomes[outcomes["status"] == "flat"]
    covers = flat["true_db"].between(flat["low_db"], flat["high_db"])
    print(covers.groupby(flat["fit"]).agg(["mean", "size"]))


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=2, help="simulated participants in each setting")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, help="where the outcomes are kept")
    parser.add_argument("--from", dest="kept", type=Path, help="outcomes that were kept")
    parser.add_argument("--estimates", type=int, metavar="SETS", help="census of point estimates and intervals instead")
    said = parser.parse_args()
    if said.estimates:
        print_estimates(said.estimates, said.seed)
        return
    if said.kept is None:
        found = []
        for each in census(settings(), said.sets, np.random.default_rng(said.seed)):
            found.append(each)
            if said.csv is not None:
                each.to_csv(said.csv, mode="w" if len(found) == 1 else "a", header=len(found) == 1, index=False)
        outcomes = pd.concat(found)
    else:
        outcomes = pd.read_csv(said.kept)
    print(tables(outcomes))


if __name__ == "__main__":
    main()
