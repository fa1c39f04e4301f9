"""Cost of absent effects: no import, no stage, no call."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import pytest
from places import ROOT
from scene_cases import ELECTROVIBRATION, LEVEL, TIME_REVERSAL, VOLT, small_screen

from tactometry.stimuli.scenes.effects import EFFECTS

LAW = {"kind": "force_law", "law": "sc_layer"}
TONE = {"frequency_hz": 60.0, "duration_s": 0.05, "ramp_s": 0.01}
PLATE = {name: value for name, value in asdict(small_screen()).items() if name != "glass"}
REST, SLIDE = {"force_n": 2.0}, {"force_n": 2.0, "speed_m_per_s": 0.05, "x_m": 0.09, "y_m": 0.06}
CASES = {**ELECTROVIBRATION, **TIME_REVERSAL, "force_law": ({"law": "sc_layer"}, (), "electrostatic_force_n")}
FELT = {"sensitivity", "receptors", "focus_detection"}
BY_DEFAULT = {"skin_mobility", "attenuation"}
"""What a surface does too at its defaults: as soon as anything is felt on it, and losses, be they none."""
OWNERS = {
    "electrovibration.waveforms.amplitude_modulated": {"carrier"},
    "electrovibration.attraction.offset": {"dc_offset"},
    "electrovibration.motion.pad": {"finger_dynamics"},
    "electrovibration.motion.driven_motion": {"friction_lag", "finger_dynamics", "dry_friction"},
    "electrovibration.motion.compiled_loops": {"finger_dynamics"},
    "electrovibration.motion.stick_slip": {"dry_friction"},
    "electrovibration.motion.power_series": {"dry_friction"},
    "perception.channels": FELT,
    "perception.detection": FELT,
    "perception.temporal_summation": {"focus_detection"},
    "scenes.stages.record": {"sensitivity", "receptors"},
    "scenes.stages.contact": {"finger_load"},
    "time_reversal.lift_off": {"lift_off"},
    "time_reversal.finger": {"focus_detection"},
    "time_reversal.focusing.pattern": {"repetition"},
    "time_reversal.plate.ritz": {"edges"},
    "time_reversal.stimulus.sensation": {"focus_detection"},
    "time_reversal.focusing.modulator": {"sigma_delta"},
    "time_reversal.focusing.sound": {"airborne_sound"},
}
"""Physics that some effects alone need."""


@dataclass(frozen=True)
class Side:
    """A surface, its effects, and its outputs with and without them."""

    surface: Mapping[str, object]
    effects: tuple[Mapping[str, object], ...]
    bare: tuple[str, ...]
    outputs: tuple[str, ...]
    kinds: tuple[str, ...]


SIDES = {
    "electrovibration": Side(
        {"kind": "electrovibration", **TONE},
        (LAW,),
        ("voltage_v",),
        ("electrostatic_force_n",),
        ("force_law", *ELECTROVIBRATION),
    ),
    "time_reversal": Side({"kind": "time_reversal", **PLATE}, (), ("peak_m",), ("peak_m",), tuple(TIME_REVERSAL)),
    "hybrid": Side(
        {"kind": "hybrid", "electrovibration": TONE, "time_reversal": PLATE},
        (LAW, {"kind": "attenuation"}),
        ("electrode_voltage_v", "peak_m"),
        ("peak_m", "electrostatic_force_n"),
        tuple(CASES),
    ),
}
EVERY = [(side, kind) for side in SIDES for kind in SIDES[side].kinds]


def table(side: str, effects, outputs):
    given = {"electrovibration": LEVEL, "time_reversal": VOLT}.get(side, {**LEVEL, **VOLT})
    contacts = {"electrovibration": [SLIDE], "time_reversal": [REST]}.get(side, [REST, SLIDE])
    surface = dict(SIDES[side].surface)
    return {
        "surface": surface, "effects": list(effects), "outputs": outputs, "given": given, "contacts": contacts,
        "accuracy": 0.1,
    }  # fmt: skip


def named(kind: str):
    return [{"kind": name, **CASES[name][0]} for name in (kind, *CASES[kind][1])]


def without(side: str, kind: str):
    company = [effect for effect in SIDES[side].effects if effect["kind"] != kind]
    bare, outputs = SIDES[side].bare, SIDES[side].outputs
    return table(side, company, bare if kind == "force_law" else outputs)


def with_it(side: str, kind: str):
    _, needs, output = CASES[kind]
    company = [effect for effect in SIDES[side].effects if effect["kind"] not in {kind, *needs}]
    slid = side == "hybrid" and output == "sensation_db" and kind in ELECTROVIBRATION
    return table(side, [*company, *named(kind)], (*SIDES[side].outputs, f"sliding_{output}" if slid else output))


def in_fresh_processes(pairs):
    """Run pairs of scenes in processes that loaded no effect before; see `fresh_processes`."""
    if not hasattr(os, "fork"):
        pytest.skip("needs os.fork for a process per effect")
    here = ROOT / "tests" / "support" / "fresh_processes.py"
    done = subprocess.run([sys.executable, here], input=json.dumps(pairs), capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def answers():
    """Return results without each effect, with it, and again without it.

    Includes every surface without effects.
    """
    return in_fresh_processes(
        {
            side: (
                table(side, (), SIDES[side].bare),
                {kind: (without(side, kind), with_it(side, kind)) for kind in SIDES[side].kinds},
            )
            for side in SIDES
        }
    )


def module_of(kind: str) -> str:
    return EFFECTS[kind].partition(":")[0]


def kinds_in(scene) -> set[str]:
    return {effect["kind"] for effect in scene["effects"]} - BY_DEFAULT


def imported(answer) -> set[str]:
    """Return the effects whose module is imported."""
    return {kind for kind in EFFECTS if module_of(kind) in answer["modules"]} - BY_DEFAULT


@pytest.mark.parametrize("side", SIDES)
def test_surface_without_effects_imports_no_effect_modules(answers, side):
    plain = answers[0][side]
    assert not imported(plain)
    assert not {f"tactometry.stimuli.{name}" for name in OWNERS} & set(plain["modules"])
    assert not any(name.startswith("matplotlib") for name in plain["modules"])
    if side == "electrovibration":
        assert "numba" not in plain["modules"]


@pytest.mark.parametrize(("side", "kind"), EVERY)
def test_absent_effect_costs_no_import_stage_or_call(answers, side, kind):
    never, on, lost = answers[1][side][kind]
    assert imported(never) == kinds_in(without(side, kind))
    assert imported(on) == kinds_in(with_it(side, kind)) | imported(never)
    assert not {kind, module_of(kind)} & {name for stage in never["stages"] for name in stage}
    assert {kind, module_of(kind)} & {name for stage in on["stages"] for name in stage}
    assert lost["stages"] == never["stages"]
    assert lost["calls"] == never["calls"] != on["calls"]


@pytest.mark.parametrize("physics", OWNERS)
def test_effect_physics_is_imported_only_with_effect(answers, physics):
    module = f"tactometry.stimuli.{physics}"
    for side, kind in EVERY:
        never, on, _ = answers[1][side][kind]
        named = kinds_in(with_it(side, kind))
        assert module not in never["modules"]
        assert (module in on["modules"]) == bool(OWNERS[physics] & named), (side, kind)


UNNEEDED = {
    **dict.fromkeys((*TIME_REVERSAL, *ELECTROVIBRATION), "electrode_voltage_v"),
    **dict.fromkeys(("carrier", "dc_offset", "texture"), "peak_m"),
}
"""For each effect, an output of the hybrid screen that does not need it."""


@pytest.fixture(scope="module")
def unneeded():
    """Return results without and with an effect that its output does not need."""
    pairs = {
        kind: (table("hybrid", (), (output,)), table("hybrid", named(kind), (output,)))
        for kind, output in UNNEEDED.items()
    }
    return in_fresh_processes({"hybrid": (table("hybrid", (), ("electrode_voltage_v",)), pairs)})[1]["hybrid"]


@pytest.mark.parametrize("kind", UNNEEDED)
def test_unneeded_effect_imports_only_its_own_module(unneeded, kind):
    without_it, with_effect, _ = unneeded[kind]
    modules = {module_of(effect["kind"]) for effect in named(kind)}
    packages = {module.rpartition(".")[0] for module in modules}  # whose `__init__` is empty
    added = set(with_effect["modules"]) - set(without_it["modules"])
    assert modules <= added <= modules | packages
    assert with_effect["stages"] == without_it["stages"]
    assert with_effect["calls"] == without_it["calls"]
