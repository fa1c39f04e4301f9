"""Methods of the rigs for each request type, and their answer types."""

from typing import get_type_hints

import pytest

from tactometry.experiments.bench import bench_file
from tactometry.experiments.sessions import recording, rig_kinds
from tactometry.rigs.bench import Bench
from tactometry.rigs.console import Console
from tactometry.rigs.simulated import SimulatedRig
from tactometry.session.answer import Touched
from tactometry.session.request import REQUESTS, Press, Slide
from tactometry.trials.columns import RIGS

METHODS = {
    f"_{name.lower()}": {"request": kind, "return": kind.answer_type}
    for name, kind in REQUESTS.items()
    if kind not in (Press, Slide)
} | {"_feel": {"request": Press | Slide, "return": Touched}}


@pytest.mark.parametrize("rig", [Bench, Console, SimulatedRig])
@pytest.mark.parametrize("name", METHODS)
def test_rig_method_maps_request_to_answer_type(rig, name):
    assert get_type_hints(getattr(rig, name)) == METHODS[name]


@pytest.mark.parametrize("name", RIGS)
def test_each_rig_kind_has_its_factory(name):
    assert get_type_hints(getattr(rig_kinds, name), vars(recording) | vars(bench_file))["return"] is recording.RigKind
