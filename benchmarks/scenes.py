"""Scenes: time against the number of effects, and predicted against measured time, in one run on one thread.

The times of each scene are medians of processor time over interleaved rounds; the ratio is to the first of them.
"""

import statistics
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

from measured import ratios, tell
from threadpoolctl import threadpool_limits

from tactometry.experiments.scenes import names, path_of
from tactometry.loading import resolve
from tactometry.stimuli.composition.effect import Effect, FingerContact
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal

N_ROUNDS = 7
GIVEN = {"level_db_re_1v": 40.0, "voltage_v": 30.0}
GROWING: tuple[tuple[str, dict[str, object]], ...] = (
    ("contact_area", {}),
    ("air_gap", {"gap_m": 1e-6}),
    ("skin_leakage", {}),
    ("friction", {}),
    ("friction_lag", {}),
    ("carrier", {"carrier_hz": 1000.0}),
)
FOCUSING: tuple[tuple[str, dict[str, object]], ...] = (
    ("attenuation", {}),
    ("patches", {}),
    ("audible_filter", {}),
    ("one_bit", {}),
    ("finger_load", {}),
)
LATER: tuple[tuple[str, dict[str, object]], ...] = (
    ("airborne_sound", {}),
    ("drive_energy", {}),
    ("movie", {}),
    ("focus_detection", {}),
)
"""Effects that bring outputs of their own, on top of the losses that sound needs."""


def effect(kind: str, **values: object) -> Effect:
    made: Effect = resolve(EFFECTS[kind])(**values)
    return made


def plan_of(n_effects: int, *, asked: bool) -> Plan:
    """A plan with the first effects; `asked` is whether an output needs them, or the voltage alone is asked for."""
    chosen = [effect(kind, **values) for kind, values in GROWING[:n_effects]]
    output = "voltage_v" if not asked else "friction_force_n" if n_effects > 3 else "electrostatic_force_n"
    surface = Electrovibration(60.0, duration_s=0.1, ramp_s=0.02)
    scene = Scene(surface, (effect("force_law", law="sc_layer"), *chosen), (output,), 1e-2, (FingerContact(1.0, 0.05),))
    return scene.resolve()


def focus_of(n_effects: int, *, asked: bool) -> Plan:
    """A time-reversal plan: effects on the focus, or effects that the focus does not need."""
    named = FOCUSING[:n_effects] if asked else (FOCUSING[0], *LATER[:n_effects])
    chosen = tuple(effect(kind, **values) for kind, values in named)
    return Scene(TimeReversal(), chosen, ("peak_m",), 1e-2, (FingerContact(2.0),)).resolve()


def timed(plan: Plan) -> float:
    start_s = time.process_time()
    plan.timed({name: GIVEN[name] for name in plan.given})
    return time.process_time() - start_s


def compare(title: str, plans: Sequence[Plan], named: Sequence[str], at_most: float | None = None) -> None:
    """Print the median times of plans, and their ratios to the first."""
    print(title)
    for plan in plans:
        timed(plan)
    rounds = [[timed(plan) for plan in plans] for _ in range(N_ROUNDS)]
    medians = [statistics.median(column) for column in zip(*rounds, strict=True)]
    for n, (plan, median_s) in enumerate(zip(plans, medians, strict=True)):
        print(
            f"  {n} (+ {named[n]}): {median_s * 1e3:8.3f} ms, {median_s / medians[0]:7.2f} x, "
            f"{len(plan.stages)} stages, predicted {plan.predicted_s * 1e3:8.3f} ms"
        )
    first, last = ([each[n] for each in rounds] for n in (0, -1))
    tell(f"{title}: all of them over none", ratios(last, first), at_most=at_most)


UNASKED: Mapping[str, tuple[tuple[str, dict[str, object]], ...]] = {
    "body_resistance": (("body_resistance", {"resistance_ohm": 1e5}),),
    "skin_leakage": (("skin_leakage", {}),),
    "contact_area": (("contact_area", {}),),
    "friction_lag": (("friction_lag", {}),),
    "finger_dynamics": (("finger_dynamics", {}),),
    "sensitivity": (("sensitivity", {}),),
    "receptors": (("receptors", {}),),
    "sensitivity, masking": (("sensitivity", {}), ("masking", {"level_db_re_threshold": 25.0})),
    "receptors, summation": (("receptors", {}), ("summation", {})),
}
N_AT_ONCE = 20
UNNEEDED = 1.05
"""What effects that are off may cost."""


def resolved_and_run(scene: Scene) -> float:
    """Time (s) from a scene to its outputs."""
    start_s = time.process_time()
    for _ in range(N_AT_ONCE):
        plan = scene.resolve()
        plan.run({name: GIVEN[name] for name in plan.given})
    return (time.process_time() - start_s) / N_AT_ONCE


def unasked() -> None:
    """Print what effects that no output needs add to resolving and running a scene of one second."""
    print("electrovibration, resolve and run: friction alone, and with effects beside it that voltage_v does not need")
    law, friction = effect("force_law", law="sc_layer"), effect("friction")
    bare = Scene(Electrovibration(240.0), (law, friction), ("voltage_v",), 1e-2, (FingerContact(1.0, 0.05),))
    found = []
    for name, kinds in UNASKED.items():
        fuller = replace(bare, effects=(*bare.effects, *(effect(kind, **values) for kind, values in kinds)))
        rounds = [(resolved_and_run(bare), resolved_and_run(fuller)) for _ in range(3 * N_ROUNDS)]
        alone_s, beside_s = (statistics.median(column) for column in zip(*rounds, strict=True))
        print(f"  {name:<24}{alone_s * 1e3:8.3f} ms, {beside_s / alone_s:6.3f} x")
        found.append(beside_s / alone_s)
    tell("resolve and run: with an effect that no output needs over without it, largest", max(found), at_most=UNNEEDED)


def built_in(name: str) -> None:
    """Print predicted and measured time of a built-in scene as a whole."""
    found = load_scene(path_of(name))
    plan = found.scene.resolve()
    given = {key: found.given[key] for key in plan.given}
    plan.timed(given)
    times = []
    for _ in range(3):
        start_s = time.process_time()
        plan.timed(given)
        times.append(time.process_time() - start_s)
    median_s = statistics.median(times)
    print(
        f"  {name}: measured {median_s:.3f} s, predicted {plan.predicted_s:.3f} s, {plan.predicted_s / median_s:.2f} x"
    )
    tell(f"{name}: measured", times, "s")
    tell(f"{name}: predicted over measured", plan.predicted_s / median_s)


def main() -> None:
    growing = ["none", *(kind for kind, _ in GROWING)]
    focusing, later = ["none", *(kind for kind, _ in FOCUSING)], ["attenuation", *(kind for kind, _ in LATER)]
    panels = [plan_of(n, asked=False) for n in range(len(GROWING))]
    compare("electrovibration: effects that no output needs", panels, growing, UNNEEDED)
    panels = [plan_of(n, asked=True) for n in range(len(GROWING) + 1)]
    compare("electrovibration: effects that an output needs", panels, growing)
    compare(
        "time reversal: effects that no output needs", [focus_of(n, asked=False) for n in range(5)], later, UNNEEDED
    )
    compare("time reversal: effects that an output needs", [focus_of(n, asked=True) for n in range(6)], focusing)
    unasked()
    print("built-in scenes")
    for name in names():
        built_in(name)


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
