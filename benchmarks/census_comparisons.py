"""That of docs/reference/analysis.md on comparisons: `python benchmarks/census_comparisons.py --sets 3000 --seed 1`."""

from argparse import ArgumentParser

import numpy as np
import pandas as pd

from tactometry.analysis.threshold.fitting import fit_many
from tactometry.experiments.census.comparisons import FIT, PEOPLE, WITHOUT_LAPSES, census, standard_census, summary

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


EQUAL_ASYMPTOTES = {**FIT, "equal_asymptotes": True, "lapse_beta": 80.0}
"""The fit of comparisons before both asymptotes were free."""
STANDARD_HEADS = ("standard above threshold / dB", "rate at lowest level", "PSE error / dB", "SD / dB", "covered / %",
                  "no PSE / %", "false effects / %")  # fmt: skip


def standard_table(found: pd.DataFrame) -> str:
    """As Markdown, with shares in per cent but the rate."""
    lines = ["| " + " | ".join(STANDARD_HEADS) + " |", "|" + "---|" * len(STANDARD_HEADS)]
    for row in found.itertuples(index=False):
        shares = " | ".join(f"{100 * share:.1f}" for share in (row.covered, row.none, row.false_effects))
        lines.append(f"| {row.above_db:g} | {row.rate:.2f} | {row.error:+.2f} | {row.sd:.2f} | {shares} |")
    return "\n".join(lines).replace("nan", "")


def standards(n_studies: int, seed: int) -> None:
    """Print the census of standards near the detection threshold, with the former fit and with this one."""
    before = standard_census(n_studies, np.random.default_rng(seed), fit=fit_many, **EQUAL_ASYMPTOTES)
    print(f"Equal asymptotes:\n\n{standard_table(before)}\n\nFree asymptotes:\n", flush=True)
    print(standard_table(standard_census(n_studies, np.random.default_rng(seed))))


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=200, help="simulated data sets in each row")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--without-lapses", action="store_true", help="fit with both asymptotes held at 0 and 1")
    parser.add_argument("--standards", type=int, metavar="STUDIES", help="census of standards near threshold instead")
    said = parser.parse_args()
    if said.standards:
        standards(said.standards, said.seed)
        return
    options = WITHOUT_LAPSES if said.without_lapses else FIT
    found = summary(pd.concat(census(PEOPLE, said.sets, np.random.default_rng(said.seed), options)))
    means = ", ".join(f"{name} {100 * found[name].mean():.1f} %" for name in SHARES)
    print(f"{table(found)}\n\nMean of the rows: {means}")


if __name__ == "__main__":
    main()
