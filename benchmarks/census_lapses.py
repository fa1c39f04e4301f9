"""That of docs/explanation/statistics.md on lapses: `python benchmarks/census_lapses.py --studies 40 --seed 1`."""

from argparse import ArgumentParser

import numpy as np

from tactometry.experiments.census.lapses import RULES, lapse_census

HEADS = ("rule", "lapses / %", "easy trials / %", "difference / dB", "false effects / %", "lapses detected / %")


def main() -> None:
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=20, help="simulated studies in each row")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rule", choices=RULES, help="one rule alone")
    said = parser.parse_args()
    rules = tuple(RULES) if said.rule is None else (said.rule,)
    print("| " + " | ".join(HEADS) + " |\n|" + "---|" * len(HEADS))
    for row in lapse_census(said.studies, np.random.default_rng(said.seed), rules):
        lapses = f"{100 * row['first']:g} and {100 * row['second']:g}"
        shares = f"{100 * row['false_effects']:.1f} | {100 * row['detected']:.1f}"
        cells = [row["rule"], lapses, f"{100 * row['share']:g}", f"{row['error']:+.2f}", shares]
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
