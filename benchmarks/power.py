"""Time simulated studies of a power analysis, with fits and tests: `python benchmarks/power.py`.

The results are the processor time of a study with 24 participants, tested for seven numbers of participants, and of its
sessions alone. The first study of the process is excluded, as it renders the stimuli.
"""

from dataclasses import replace
from functools import partial

from tactometry.experiments.harness import run_once, tell
from tactometry.experiments.power.design import PowerDesign, participants_of
from tactometry.experiments.power.effect import parse_effect
from tactometry.experiments.power.replicate import replicate, seed_of, simulated
from tactometry.experiments.power.scenario import check_design, experiment_of
from tactometry.experiments.study.study_file import load

ASKED = {"tutorial": "frequency_hz: 2 dB", "electrovibration-threshold": "force_n: 2 dB"}
N_TRIALS, N_STUDIES = 40, 3


def main() -> None:
    for name, effect in ASKED.items():
        made = PowerDesign(load(name)[1], name, parse_effect(effect), participants_of("6..24"), (N_TRIALS,), seed=1)
        design = replace(made, dependent=check_design(made))
        case = design.cases[0]
        replicate(design, case, 0)
        sessions = partial(simulated, design, experiment_of(design, case))
        seeds = [seed_of(design.seed, number) for number in range(1, 1 + N_STUDIES)]
        sessions_s = [run_once(partial(sessions, seed))[0] for seed in seeds]
        studies_s = [run_once(partial(replicate, design, case, number))[0] for number in range(1, 1 + N_STUDIES)]
        tell(f"{name}: a study of 24 people, tested for seven numbers of them", studies_s, "s")
        tell(f"{name}: its sessions alone", sessions_s, "s")


if __name__ == "__main__":
    main()
