"""Look-up and rendering of stimuli by name, which every rig does alike."""

import io

import catalogue
import pytest

from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import NullOutput
from tactometry.errors import InvalidParameter, LimitExceeded
from tactometry.observers.finger import SimulatedFinger
from tactometry.rigs.bench import Bench
from tactometry.rigs.console import Console
from tactometry.rigs.device_rig import Equipment
from tactometry.rigs.pages.page import Display
from tactometry.rigs.simulated import SimulatedRig
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.session.request import Play

BANK = {"tone": catalogue.AnyStimulus()["any"]}
TIGHT = Limits(1e-6)


def bench(limits):
    output = Guarded(NullOutput(), Limits(1000.0))
    return Bench(Display(), Equipment(output, BANK, limits), texts_in("en", {}))


def console(limits):
    return Console(catalogue.silent(BANK, limits), texts_in("en", {}), io.StringIO(), io.StringIO())


def simulated(limits):
    return SimulatedRig(
        BANK, limits, sensation=None, observer=None, finger=SimulatedFinger(), rng_of=lambda n: None, decisions={}
    )


@pytest.mark.parametrize("rig_with", [bench, console, simulated])
def test_every_rig_suggests_nearest_stimulus_name(rig_with):
    with pytest.raises(InvalidParameter, match="stimulus: found 'tome', expected one of tone; did you mean 'tone'?"):
        rig_with(Limits(1000.0)).answer(Play("tome", 20.0, 1.0))


@pytest.mark.parametrize("rig_with", [bench, console, simulated])
def test_every_rig_enforces_study_limits(rig_with):
    with pytest.raises(LimitExceeded, match=r"limits\.voltage_peak_v: .*nothing was played"):
        rig_with(TIGHT).answer(Play("tone", 20.0, 1.0))
