"""What a level through a scene costs beside the formula of the same effects, and how far they are apart.

OMP_NUM_THREADS=1 python benchmarks/scene_in_study.py
"""

import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median

from tactometry.contact import Contact
from tactometry.experiments.scenes import path_of
from tactometry.signal import Signal
from tactometry.stimuli.electrovibration import AmplitudeModulated, ElectrovibrationSensation
from tactometry.stimuli.scenes.file import load_scene

N_ROUNDS = 9
STIMULUS = AmplitudeModulated(240.0, duration_s=0.5)
Feel = Callable[[Signal, Contact], float]


def process_s(feel: Feel, signal: Signal, contact: Contact) -> float:
    start_s = time.process_time()
    feel(signal, contact)
    return time.process_time() - start_s


def main() -> None:
    panel = load_scene(path_of("electrovibration-panel")).scene
    tone = replace(panel.surface, duration_s=STIMULUS.duration_s, ramp_s=STIMULUS.ramp_s)  # type: ignore[type-var]
    through = {
        f"scene, accuracy {accuracy:g}": replace(panel, surface=tone, accuracy=accuracy).sensation
        for accuracy in (0.01, 0.05, 0.2)
    }
    ways: dict[str, Feel] = {"formula": ElectrovibrationSensation().sensation_db, **through}
    times: dict[tuple[str, str], list[float]] = {}
    for n in range(N_ROUNDS):  # interleaved; the first round compiles
        signal, first, second = STIMULUS.at(20 + n), Contact(1 + n / 50, 0.05), Contact(1 + n / 50, 0.051)
        for way, feel in ways.items():
            calls = {"new signal": first, "new contact": second, "both as before": second}
            for what, contact in calls.items():
                spent_s = process_s(feel, signal, contact)
                times.setdefault((way, what), []).extend([spent_s] if n else [])
    for (way, what), spent in times.items():
        ratio = median(spent) / median(times["formula", what])
        print(f"{way:<22}{what:<16}{1e3 * median(spent):8.2f} ms  {ratio:8.1f} times the formula")
    signal, contact = STIMULUS.at(30.0), Contact(1.5, 0.05)
    levels_db = {way: feel(signal, contact) for way, feel in ways.items()}
    for way, level_db in levels_db.items():
        print(f"{way:<22}{level_db:.4f} dB, {level_db - levels_db['formula']:+.4f} dB beside the formula")


if __name__ == "__main__":
    main()
