"""The table of docs/reference/analysis.md on intervals of the hierarchical fit.

`python benchmarks/census_groups.py --studies 60 --seed 1 --csv groups.csv`; an interrupted run continues.
"""

from argparse import ArgumentParser
from pathlib import Path

import pandas as pd

from tactometry.experiments.census.groups import census, summary


def table(outcomes: pd.DataFrame) -> str:
    """As Markdown."""
    heads = [
        "procedure",
        "lapses",
        "studies",
        "participants",
        "group means",
        "contrast",
        "mean error, dB",
        "worst mean, dB",
    ]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for row in summary(outcomes).itertuples(index=False):
        pairs = ((row.participants, row.se), (row.means, row.se_means), (row.contrast, row.se_contrast))
        shares = [f"{share:.1f} ± {error:.1f}" for share, error in pairs]
        cells = [row.procedure, row.lapses, str(row.studies), *shares, f"{row.error_db:+.2f}", f"{row.worst_db:+.1f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=2, help="simulated studies in each row")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, required=True, help="where the outcomes are kept")
    said = parser.parse_args()
    done = int(pd.read_csv(said.csv)["study"].max()) + 1 if said.csv.exists() else 0
    for each in census(range(done, said.studies), said.seed):
        each.to_csv(said.csv, mode="a", header=not said.csv.exists(), index=False)
    print(table(pd.read_csv(said.csv)))


if __name__ == "__main__":
    main()
