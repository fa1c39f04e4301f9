"""Simulated studies of a power analysis, each with its fits and its tests: `python benchmarks/power.py`.

Prints the processor time of a study of 24 people that is tested for seven numbers of them, and of its sessions alone;
without the first study of the process, which renders what all feel.
"""

import platform
from dataclasses import replace
from time import process_time

from measured import tell

from tactometry.experiments.power.design import PowerDesign, participants_of
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.replicate import replicate, seed_of, simulated
from tactometry.experiments.power.scenario import check_design, experiment_of
from tactometry.experiments.study.study_file import load

ASKED = {"tutorial": "frequency_hz: 2 dB", "electrovibration-threshold": "force_n: 2 dB"}
N_TRIALS = 40
N_STUDIES = 3


def design(name: str, effect: str) -> PowerDesign:
    made = PowerDesign(load(name)[1], name, parse_effect(effect), participants_of("6..24"), (N_TRIALS,), seed=1)
    return replace(made, dependent=check_design(made))


def main() -> None:
    print(f"Python {platform.python_version()}, {platform.machine()}, one process")
    for name, effect in ASKED.items():
        asked = design(name, effect)
        case = asked.cases[0]
        replicate(asked, case, 0)
        sessions_s, studies_s = [], []
        for number in range(1, 1 + N_STUDIES):
            begun = process_time()
            trials = simulated(asked, experiment_of(asked, case), seed_of(asked.seed, number))
            of_sessions = process_time() - begun
            begun = process_time()
            replicate(asked, case, number)
            whole = process_time() - begun
            print(f"{name:<28} {len(trials.rows):>6} rows, sessions {of_sessions:.2f} s, whole study {whole:.2f} s")
            sessions_s.append(of_sessions)
            studies_s.append(whole)
        tell(f"{name}: a study of 24 people, tested for seven numbers of them", studies_s, "s")
        tell(f"{name}: its sessions alone", sessions_s, "s")


if __name__ == "__main__":
    main()
