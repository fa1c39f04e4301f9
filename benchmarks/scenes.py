"""Time scenes by number of effects, and compare with the predicted times."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from statistics import median
from typing import Any

from threadpoolctl import threadpool_limits

from tactometry.experiments.harness import interleaved, ratios, tell
from tactometry.experiments.scenes import names, path_of
from tactometry.loading import resolve
from tactometry.stimuli.composition.effect import Effect, FingerContact
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.file import load_scene
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.time_reversal import TimeReversal

N_ROUNDS, UNNEEDED = 7, 1.05
"""Number of rounds, and the largest accepted cost of effects that no output needs."""
GIVEN = {"level_db_re_1v": 40.0, "voltage_v": 30.0}
Tables = Mapping[str, Mapping[str, Any]]
FRICTION: Tables = {
    "contact_area": {},
    "air_gap": {"gap_m": 1e-6},
    "skin_leakage": {},
    "friction": {},
    "friction_lag": {},
    "carrier": {"carrier_hz": 1000.0},
}
FOCUS: Tables = {"attenuation": {}, "patches": {}, "audible_filter": {}, "one_bit": {}, "finger_load": {}}
LATER: Tables = {"airborne_sound": {}, "drive_energy": {}, "movie": {}, "focus_detection": {}}
"""Effects with separate outputs, in addition to the losses that the sound requires."""
UNASKED: Sequence[Tables] = (
    {"body_resistance": {"resistance_ohm": 1e5}},
    {"skin_leakage": {}},
    {"contact_area": {}},
    {"friction_lag": {}},
    {"finger_dynamics": {}},
    {"sensitivity": {}},
    {"receptors": {}},
    {"sensitivity": {}, "masking": {"level_db_re_threshold": 25.0}},
    {"receptors": {}, "summation": {}},
)


def effects(tables: Tables) -> tuple[Effect, ...]:
    return tuple(resolve(EFFECTS[kind])(**values) for kind, values in tables.items())


def first(tables: Tables, n: int) -> Tables:
    return dict(list(tables.items())[:n])


def panel(n_effects: int, output: str) -> Plan:
    chosen = effects({"force_law": {"law": "sc_layer"}, **first(FRICTION, n_effects)})
    surface = Electrovibration(60.0, duration_s=0.1, ramp_s=0.02)
    return Scene(surface, chosen, (output,), 1e-2, (FingerContact(1.0, 0.05),)).resolve()


def focus(tables: Tables) -> Plan:
    return Scene(TimeReversal(), effects(tables), ("peak_m",), 1e-2, (FingerContact(2.0),)).resolve()


def given(plan: Plan) -> dict[str, float]:
    return {name: GIVEN[name] for name in plan.given}


def compare(title: str, plans: Sequence[Plan], at_most: float | None = None) -> None:
    """Time plans with an increasing number of effects."""
    calls = {str(n): lambda plan=plan: plan.timed(given(plan)) for n, plan in enumerate(plans)}
    times = interleaved(calls, N_ROUNDS)
    medians_s = {name: median(each) for name, each in times.items()}
    print(f"{title}: {', '.join(f'{name}: {1e3 * each:.3f} ms' for name, each in medians_s.items())}")
    tell(f"{title}: all of them over none", ratios(times[str(len(plans) - 1)], times["0"]), at_most=at_most)


def unasked() -> None:
    """Time scenes of one second, with and without effects that voltage_v does not need."""
    chosen = effects({"force_law": {"law": "sc_layer"}, "friction": {}})
    bare, result = Scene(Electrovibration(240.0), chosen, ("voltage_v",), 1e-2, (FingerContact(1.0, 0.05),)), []

    def run(scene: Scene) -> None:
        for _ in range(20):
            plan = scene.resolve()
            plan.run(given(plan))

    for tables in UNASKED:
        fuller = replace(bare, effects=(*bare.effects, *effects(tables)))
        times = interleaved({"bare": lambda: run(bare), "fuller": lambda s=fuller: run(s)}, 3 * N_ROUNDS)
        result.append(median(times["fuller"]) / median(times["bare"]))
    tell("resolve and run: with an effect that no output needs over without it, largest", max(result), at_most=UNNEEDED)


def built_in(name: str) -> None:
    scene = load_scene(path_of(name))
    plan = scene.scene.resolve()
    values = {key: scene.given[key] for key in plan.given}
    times = interleaved({name: lambda: plan.timed(values)}, 3)[name]
    tell(f"{name}: measured", times, "s")
    tell(f"{name}: predicted over measured", plan.predicted_s / median(times))


def main() -> None:
    n = len(FRICTION)
    compare("electrovibration: effects that no output needs", [panel(k, "voltage_v") for k in range(n)], UNNEEDED)
    outputs = ["electrostatic_force_n" if k <= 3 else "friction_force_n" for k in range(n + 1)]
    needed = [panel(k, output) for k, output in enumerate(outputs)]
    compare("electrovibration: effects that an output needs", needed)
    later = [focus({**first(FOCUS, 1), **first(LATER, k)}) for k in range(len(LATER) + 1)]
    compare("time reversal: effects that no output needs", later, UNNEEDED)
    compare("time reversal: effects that an output needs", [focus(first(FOCUS, k)) for k in range(len(FOCUS) + 1)])
    unasked()
    for name in names():
        built_in(name)


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
