"""What a level through the default scene of each surface costs beside the formula of the same laws, warm and cold, what
effects that are off add, and what those cost that are no factor of components. All are ratios of interleaved pairs.

OMP_NUM_THREADS=1 python benchmarks/scene_in_study.py
"""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from measured import ratios, tell

from tactometry.contact import Contact
from tactometry.loading import resolve
from tactometry.signal import Signal

if TYPE_CHECKING:
    from tactometry.stimuli.scenes.scene import Scene  # imported in a first call that needs it, and not before

SUPPORT = Path(__file__).resolve().parents[1] / "tests" / "support"
sys.path[:0] = [str(SUPPORT)]

N_ROUNDS, N_COLD, N_RUNS = 60, 5, 200
Feel = Callable[[Signal, Contact], float]
WAVEFORM = "tactometry.stimuli.electrovibration.waveforms.amplitude_modulated:AmplitudeModulated"
TRAIN = "tactometry.stimuli.time_reversal.stimulus.focus_train:FocusTrain"
FOCI = "tactometry.stimuli.time_reversal.stimulus.sensation:TimeReversalSensation"


@dataclass(frozen=True)
class Surface:
    """A surface, the model of `[sensation]` on it, and which effects of it are off where a signal is felt."""

    name: str
    room: str
    model: str
    off: tuple[str, ...] = ()
    numbers: tuple[tuple[str, str], ...] = ()

    def stimulus(self) -> Any:
        if self.room == "electrovibration":
            return resolve(WAVEFORM)(240.0, duration_s=0.5)
        focus = resolve(TRAIN)(f_max_hz=20e3, voltage_max_v=1e4)
        if self.room == "time_reversal":
            return focus
        friction = resolve(WAVEFORM)(120.0, duration_s=focus.duration_s, rate_hz=focus.setup.rate_hz)
        return resolve("tactometry.stimuli.hybrid:Hybrid")(focus, friction)

    def of_model(self) -> Any:
        return resolve(self.model)(**dict(self.numbers))

    def scene(self) -> "Scene":
        made: Scene = resolve("tactometry.stimuli.scenes.default_scenes:default_scene")(self.of_model())
        return made

    def formula(self) -> Feel:
        return partial(import_module(f"{self.room}_formula").level_db, self.of_model())


IDLE = ("movie", "drive_energy")
PANEL = "tactometry.stimuli.electrovibration.sensation:ElectrovibrationSensation"
BY_ROOM = (
    Surface("electrovibration", "electrovibration", PANEL),
    Surface("foci", "time_reversal", FOCI, IDLE),
    Surface("foci under a load", "time_reversal", FOCI, IDLE, (("criterion", "loaded"),)),
    Surface("hybrid", "hybrid", "tactometry.stimuli.hybrid:HybridSensation", IDLE),
)
SURFACES = {surface.name: surface for surface in BY_ROOM}


def process_s(call: Callable[..., object], *given: object) -> float:
    start_s = time.process_time()
    call(*given)
    return time.process_time() - start_s


def with_effects(scene: "Scene", *tables: tuple[str, dict[str, float]]) -> "Scene":
    """A scene with further effects, in the place of those in their slots."""
    from tactometry.stimuli.scenes.effects import EFFECTS

    added = tuple(resolve(EFFECTS[kind])(**values) for kind, values in tables)
    slots = {effect.slot for effect in added}
    return replace(scene, effects=(*(effect for effect in scene.effects if effect.slot not in slots), *added))


def ways(surface: Surface) -> dict[str, Feel]:
    scene = surface.scene()
    felt = {"formula": surface.formula(), "default scene": scene.sensation}
    if surface.room == "electrovibration":
        for accuracy in (0.01, 0.05):
            felt[f"accuracy {accuracy:g}"] = replace(scene, accuracy=accuracy).sensation
    else:
        idle = with_effects(scene, *((kind, {}) for kind in surface.off))
        assert {effect.kind for effect in idle.felt().off()} == set(surface.off)
        felt[f"off: {', '.join(surface.off)}"] = idle.sensation
    return felt


def warm(surface: Surface) -> Iterator[tuple[str, str, float]]:
    """Of each round, way and call the time; the first round compiles."""
    felt, stimulus = ways(surface), surface.stimulus()
    for n in range(N_ROUNDS + 1):
        signal, first, second = stimulus.at(20 + n / 40), Contact(1 + n / 50, 0.05), Contact(1 + n / 50, 0.051)
        signal.digest()  # of all that is played, whoever feels it
        calls = {"new signal": first, "new contact": second, "both as before": second}
        for way, feel in felt.items():
            for what, contact in calls.items():
                spent_s = process_s(feel, signal, contact)
                if n:
                    yield way, what, spent_s


def tell_warm(surface: Surface) -> None:
    times: dict[tuple[str, str], list[float]] = {}
    for way, what, spent_s in warm(surface):
        times.setdefault((way, what), []).append(spent_s)
    for (way, what), spent in times.items():
        other = "default scene" if way.startswith("off") else "formula"
        beside = ratios(spent, times[other, what])
        ratio = median(beside)
        print(f"{surface.name:<18}{way:<38}{what:<15}{1e3 * median(spent):8.3f} ms  {ratio:6.2f} times the {other}")
        if way != "formula":
            limit = 1.05 if way.startswith("off") else 1.2 if way == "default scene" else None
            tell(f"{surface.name}, {what}: {way} over the {other}", beside, at_most=limit)


def first_call_s(name: str, way: str) -> None:
    """Print the time of imports and a first call in this process, the signal given."""
    surface = SURFACES[name]
    signal, contact = surface.stimulus().at(20.0), Contact(1.5, 0.05)

    def first() -> float:
        feel = surface.formula() if way == "formula" else surface.scene().sensation
        return feel(signal, contact)

    print(process_s(first))


def tell_cold(surface: Surface) -> None:
    """First calls in processes of their own."""
    pairs = []
    for _ in range(N_COLD):
        told = [
            subprocess.run([sys.executable, __file__, surface.name, way], capture_output=True, text=True, check=True)
            for way in ("formula", "scene")
        ]
        pairs.append([float(one.stdout) for one in told])
    ratio, (formula_s, scene_s) = median(b / a for a, b in pairs), map(median, zip(*pairs, strict=True))
    times_ms = f"{1e3 * scene_s:.1f} ms, formula {1e3 * formula_s:.1f} ms"
    print(f"{surface.name:<18}first call of a process: scene {times_ms}, {ratio:.2f} times")
    tell(f"{surface.name}: first call of a process, scene over formula", [b / a for a, b in pairs], at_most=1.2)


def tell_off_on_a_panel() -> None:
    """A panel that is asked for its attraction, with all that makes friction of it and a threshold beside it."""
    from tactometry.experiments.scenes import path_of
    from tactometry.stimuli.scenes.file import load_scene

    panel = replace(load_scene(path_of("electrovibration-panel")).scene, outputs=("electrostatic_force_n",))
    slots = {effect.slot for effect in panel.off()}
    bare = replace(panel, effects=tuple(effect for effect in panel.effects if effect.slot not in slots))
    assert slots == {"friction", "dynamics", "sensitivity"}
    assert not bare.off()
    plans, given = [bare.resolve(), panel.resolve()], {"level_db_re_1v": 30.0}
    times = [[process_s(plan.run, given) for plan in plans] for _ in range(N_RUNS)][1:]
    ratio = median(with_s / without_s for without_s, with_s in times)
    tell(f"panel, attraction: with {len(slots)} effects off, over without them", ratio, at_most=1.05)


def tell_courses() -> None:
    """What is no factor of components: computed anew for each contact."""
    scene = SURFACES["electrovibration"].scene()
    signal, formula = SURFACES["electrovibration"].stimulus().at(30.0), SURFACES["electrovibration"].formula()
    courses = {
        "body_resistance": (("body_resistance", {"resistance_ohm": 1e4}),),
        "dry_friction": (("dry_friction", {}), ("finger_dynamics", {})),
    }
    bare = replace(scene, effects=tuple(effect for effect in scene.effects if effect.slot != "mobility"))
    for kind, tables in courses.items():
        feel = with_effects(bare, *tables).sensation
        spent = [[process_s(way, signal, Contact(1 + n / 50, 0.05)) for way in (formula, feel)] for n in range(6)][1:]
        spent_ms = 1e3 * median(with_it for _, with_it in spent)
        print(f"electrovibration  {kind:<38}new contact    {spent_ms:8.3f} ms")


def main() -> None:
    for surface in SURFACES.values():
        tell_warm(surface)
        tell_cold(surface)
    tell_off_on_a_panel()
    tell_courses()


if __name__ == "__main__":
    first_call_s(*sys.argv[1:]) if sys.argv[1:] else main()
