"""The tables of docs/reference/analysis.md on statuses.

`python benchmarks/census.py --sets 20 --seed 1 --csv outcomes.csv`

`--from outcomes.csv` makes the tables of outcomes kept before.
"""

from argparse import ArgumentParser
from pathlib import Path

import numpy as np
import pandas as pd

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
PLACES, N_TRIALS = ("inside", "2 below", "2 above"), 40


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
    """By place and number of trials; and by procedure and task, for one number of trials."""
    some = outcomes[outcomes["place"].isin(PLACES) & (outcomes["n_trials"] == N_TRIALS)]
    by_place = outcomes.sort_values("n_trials", kind="stable").sort_values("place", kind="stable", key=_order(outcomes))
    each = (table(by_place, ["place", "n_trials"]), *(table(some, [name, "place"]) for name in ("procedure", "task")))
    return "\n\n".join(each)


def _order(outcomes: pd.DataFrame):  # type: ignore[no-untyped-def]
    """Places in the order in which they come."""
    places = list(dict.fromkeys(outcomes["place"]))
    return lambda column: column.map(places.index)


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=2, help="simulated participants in each setting")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, help="where the outcomes are kept")
    parser.add_argument("--from", dest="kept", type=Path, help="outcomes that were kept")
    said = parser.parse_args()
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
