"""A study imports only the effects that its scene states."""

import json
import os
import subprocess
import sys

import pytest
from places import ROOT
from scene_cases import ELECTROVIBRATION, TIME_REVERSAL
from scene_studies import FOCI, scene

from tactometry.loading import resolve
from tactometry.stimuli.scenes.effects import EFFECTS, OF_ELECTROVIBRATION, OF_TIME_REVERSAL

CASES = {**ELECTROVIBRATION, **TIME_REVERSAL}


def inline(kind):
    values = {"law": '"sc_layer"'} if kind == "force_law" else CASES[kind][0]
    return "{ " + ", ".join([f'kind = "{kind}"', *(f"{key} = {value}" for key, value in values.items())]) + " }"


SLOTS = {"dry_friction": "friction", "receptors": "sensitivity", "summation": "sensitivity"}


def with_company(kind):
    needs = CASES[kind][1] if kind in CASES else ()
    return ({kind, *needs, "force_law", "friction", "sensitivity"} - {SLOTS.get(kind)}) - {"plain"}


PANEL_KINDS = [kind for kind in OF_ELECTROVIBRATION if not resolve(EFFECTS[kind]).in_signal]
PLATE_KINDS = ["finger_load", "focus_detection", "movie", "drive_energy"]
OTHERS = [kind for kind in OF_TIME_REVERSAL if not resolve(EFFECTS[kind]).in_signal]
ALWAYS = {"skin_mobility"}
"""What a panel has by default in its scenes: friction moves the skin."""
UNFELT = {"movie": "focus_detection", "drive_energy": "focus_detection"}


@pytest.fixture(scope="module")
def loaded():
    """Return each scene's effects and loaded modules, in separate processes."""
    if not hasattr(os, "fork"):
        pytest.skip("needs os.fork for a process per effect")
    panels = {kind: with_company(kind) for kind in [*PANEL_KINDS, "plain"]}
    plates = {kind: {kind, "focus_detection"} for kind in PLATE_KINDS}
    studies = {kind: scene(*map(inline, sorted(kinds))) for kind, kinds in panels.items()}
    for kind, kinds in plates.items():
        studies[kind] = f"{FOCI}\n[scene]\neffects = [{', '.join(map(inline, sorted(kinds)))}]\n"
    tissue = inline("focus_detection"), '{ kind = "finger_load", impedance = "tissue" }'
    studies["tissue"] = f"{FOCI}\n[scene]\neffects = [{', '.join(tissue)}]\n"
    script = ROOT / "tests" / "support" / "felt_processes.py"
    done = subprocess.run(
        [sys.executable, script], input=json.dumps(studies), capture_output=True, text=True, check=True
    )
    return panels | plates, {kind: set(modules) for kind, modules in json.loads(done.stdout).items()}


@pytest.mark.parametrize("kind", [*PANEL_KINDS, *PLATE_KINDS])
def test_study_imports_only_effects_of_its_scene(loaded, kind):
    stated, modules = loaded
    found = {name for name in (*PANEL_KINDS, *OTHERS) if EFFECTS[name].partition(":")[0] in modules[kind]}
    assert found - ALWAYS == stated[kind] - ALWAYS
    assert "tactometry.stimuli.electrovibration.sensation" not in modules[kind]


@pytest.mark.parametrize("kind", UNFELT)
def test_unneeded_effect_is_not_imported(loaded, kind):
    _, modules = loaded
    named = EFFECTS[kind].partition(":")[0]
    assert {named} <= modules[kind] - modules[UNFELT[kind]] <= {named, named.rpartition(".")[0]}


def test_pulp_is_imported_for_a_load_of_tissue_only(loaded):
    _, modules = loaded
    pulp = "tactometry.stimuli.time_reversal.pulp"
    assert {kind for kind, names in modules.items() if pulp in names} == {"tissue"}
