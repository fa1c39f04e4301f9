"""What a level through a scene costs beside the formula of the same effects, warm and cold, and what those that are off
or that are no factor of components add.

OMP_NUM_THREADS=1 python benchmarks/scene_in_study.py
"""

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median

from tactometry.contact import Contact
from tactometry.experiments.scenes import path_of
from tactometry.loading import resolve
from tactometry.signal import Signal
from tactometry.stimuli.electrovibration import AmplitudeModulated, ElectrovibrationSensation
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.scene import Scene

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests" / "support")]

N_ROUNDS = 60
STIMULUS = AmplitudeModulated(240.0, duration_s=0.5)
Feel = Callable[[Signal, Contact], float]
COURSES = ("body_resistance", "dry_friction")
"""What is no factor of components: computed anew for each contact, and in a few rounds only."""


def process_s(feel: Feel, signal: Signal, contact: Contact) -> float:
    start_s = time.process_time()
    feel(signal, contact)
    return time.process_time() - start_s


def with_effects(scene: Scene, *tables: tuple[str, dict[str, float]]) -> Scene:
    """A scene with further effects, in the place of those in their slots."""
    added = tuple(resolve(EFFECTS[kind])(**values) for kind, values in tables)
    slots = {effect.slot for effect in added}
    return replace(scene, effects=(*(effect for effect in scene.effects if effect.slot not in slots), *added))


def ways() -> dict[str, Feel]:
    from separate_formulas import level_db

    panel = load_scene(path_of("electrovibration-panel")).scene
    scenes = {f"scene, accuracy {accuracy:g}": replace(panel, accuracy=accuracy) for accuracy in (0.01, 0.05)}
    plain = replace(panel, effects=tuple(effect for effect in panel.effects if effect.slot != "dynamics"))
    scenes["scene without a lag"] = plain
    scenes["the same, one effect off"] = with_effects(plain, ("finger_dynamics", {}))
    scenes["body_resistance"] = with_effects(panel, ("body_resistance", {"resistance_ohm": 1e4}))
    scenes["dry_friction"] = with_effects(panel, ("dry_friction", {}), ("finger_dynamics", {}))
    formula = partial(level_db, ElectrovibrationSensation())
    return {"formula": formula, **{name: of.sensation for name, of in scenes.items()}}


def main() -> None:
    times: dict[tuple[str, str], list[float]] = {}
    felt = ways()
    for n in range(N_ROUNDS):  # interleaved; the first round compiles
        signal, first, second = STIMULUS.at(20 + n / 4), Contact(1 + n / 50, 0.05), Contact(1 + n / 50, 0.051)
        signal.digest()  # of all that is played, whoever feels it
        for way, feel in felt.items():
            calls = {"new signal": first, "new contact": second, "both as before": second}
            for what, contact in calls.items() if way not in COURSES or n < 6 else ():
                spent_s = process_s(feel, signal, contact)
                times.setdefault((way, what), []).extend([spent_s] if n else [])
    for (way, what), spent in times.items():
        ratio = median(spent) / median(times["formula", what])
        print(f"{way:<26}{what:<16}{1e3 * median(spent):8.3f} ms  {ratio:8.2f} times the formula")
    signal, contact = STIMULUS.at(30.0), Contact(1.5, 0.05)
    levels_db = {way: feel(signal, contact) for way, feel in felt.items()}
    for way, level_db in levels_db.items():
        print(f"{way:<26}{level_db:.4f} dB, {level_db - levels_db['formula']:+.4f} dB beside the formula")


if __name__ == "__main__":
    main()
