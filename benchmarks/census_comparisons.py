"""That of docs/reference/analysis.md on comparisons: `python benchmarks/census_comparisons.py --sets 3000 --seed 1`."""

from argparse import ArgumentParser

import numpy as np
import pandas as pd

from tactometry.experiments.census.comparisons import FIT, PEOPLE, WITHOUT_LAPSES, census, summary

SHARES = ("jnd_covered", "jnd_above", "jnd_below", "pse_covered")
HEADS = ("SD", "trials per level", "lapses / %", "JND covered", "above", "below", "PSE covered", "JND / truth")


def table(found: pd.DataFrame) -> str:
    """As Markdown, shares in per cent."""
    lines = ["| " + " | ".join(HEADS) + " |", "|" + "---|" * len(HEADS)]
    for row in found.itertuples(index=False):
        shares = [f"{100 * getattr(row, name):.1f}" for name in SHARES]
        cells = [f"{row.sd:g}", f"{row.n_trials}", f"{100 * row.lapse_rate:g}", *shares, f"{row.jnd_over_truth:.2f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=200, help="simulated data sets in each row")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--without-lapses", action="store_true", help="fit with both asymptotes held at 0 and 1")
    said = parser.parse_args()
    options = WITHOUT_LAPSES if said.without_lapses else FIT
    found = summary(pd.concat(census(PEOPLE, said.sets, np.random.default_rng(said.seed), options)))
    means = ", ".join(f"{name} {100 * found[name].mean():.1f} %" for name in SHARES)
    print(f"{table(found)}\n\nMean of the rows: {means}")


if __name__ == "__main__":
    main()
