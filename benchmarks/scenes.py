"""Scenes: time against the number of effects, and predicted against measured time, in one run on one thread.

The times of each scene are medians over interleaved rounds; the ratio is to the scene without effects.
"""

import statistics
import time

from threadpoolctl import threadpool_limits

from tactometry.stimuli.scenes.effect import Effect, Touch
from tactometry.stimuli.scenes.effects import EFFECTS
from tactometry.stimuli.scenes.plan import Plan
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.target import resolve

N_ROUNDS = 7
GIVEN = {"level_db_re_1v": 40.0}
GROWING: tuple[tuple[str, dict[str, object]], ...] = (
    ("contact_area", {}),
    ("air_gap", {"gap_m": 1e-6}),
    ("skin_leakage", {}),
    ("friction", {}),
    ("friction_lag", {}),
    ("carrier", {"carrier_hz": 1000.0}),
)


def effect(kind: str, **values: object) -> Effect:
    made: Effect = resolve(EFFECTS[kind])(**values)
    return made


def plan_of(n_effects: int, *, asked: bool) -> Plan:
    """A plan with the first effects; `asked` is whether an output needs them, or the voltage alone is asked for."""
    chosen = [effect(kind, **values) for kind, values in GROWING[:n_effects]]
    output = "voltage_v" if not asked else "friction_force_n" if n_effects > 3 else "electrostatic_force_n"
    surface = Electrovibration(60.0, duration_s=0.1, ramp_s=0.02)
    scene = Scene(surface, (effect("force_law", law="sc_layer"), *chosen), (output,), 1e-2, (Touch(1.0, 0.05),))
    return scene.resolve()


def timed(plan: Plan) -> float:
    start_s = time.perf_counter()
    plan.timed({name: GIVEN[name] for name in plan.given})
    return time.perf_counter() - start_s


def main() -> None:
    for asked in (False, True):
        print("effects that an output needs" if asked else "effects that no output needs")
        plans = [plan_of(n, asked=asked) for n in range(len(GROWING) + (1 if asked else 0))]
        for plan in plans:
            timed(plan)
        rounds = [[timed(plan) for plan in plans] for _ in range(N_ROUNDS)]
        medians = [statistics.median(column) for column in zip(*rounds, strict=True)]
        for n, (plan, median_s) in enumerate(zip(plans, medians, strict=True)):
            named = GROWING[n - 1][0] if n else "none"
            print(
                f"  {n} (+ {named}): {median_s * 1e3:8.3f} ms, {median_s / medians[0]:7.2f} x, "
                f"{len(plan.stages)} stages, predicted {plan.predicted_s * 1e3:8.3f} ms"
            )


if __name__ == "__main__":
    with threadpool_limits(1):
        main()
