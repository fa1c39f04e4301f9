"""Invalid values for one argument at a time of every public callable.

The result is finite or an error of one sentence, without warnings or tracebacks. The error names an argument that
is not a finite number.
"""

import importlib
import inspect
import math
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from time_reversal_calls import (
    BAND,
    CLICK,
    DESIGN,
    EMISSION,
    FOCUS,
    PLATE,
    RESPONSES,
    ROOM,
    SCREEN,
    SETUP,
    SHEETS,
    TRAIN,
    calls,
)

import tactometry.stimuli.time_reversal as room
from tactometry.errors import TactometryError
from tactometry.stimuli.composition.effect import Effect
from tactometry.stimuli.time_reversal import (
    DiscPatch,
    Fingertip,
    Glass,
    Pattern,
    Target,
    TimeReversalSensation,
    TimeReversalStimulus,
)
from tactometry.stimuli.time_reversal.design.guide import Transducers
from tactometry.stimuli.time_reversal.filters import Butterworth
from tactometry.stimuli.time_reversal.finger import Contactor
from tactometry.stimuli.time_reversal.focusing.one_bit import OneBit
from tactometry.stimuli.time_reversal.focusing.pattern import Exponential, RaisedCosine, Rectangular, Sinc, Table
from tactometry.stimuli.time_reversal.focusing.pulse_width import PulseWidth
from tactometry.stimuli.time_reversal.focusing.quantiser import Analogue
from tactometry.stimuli.time_reversal.focusing.sigma_delta import SigmaDelta
from tactometry.stimuli.time_reversal.focusing.sound import NoiseSpectrum
from tactometry.stimuli.time_reversal.pulp import PulpLoad, Tissue
from tactometry.stimuli.time_reversal.responses.learning import Excitation
from tactometry.stimuli.time_reversal.responses.load import PlateLoad, SprungMass
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.glass_panel import GlassPanel
from tactometry.stimuli.time_reversal.screen.transducer import Patch, PointForce
from tactometry.stimuli.time_reversal.stimulus.sensation import FocusReading

HOSTILE: Mapping[str, Any] = {
    "None": None,
    "text": "wide",
    "nan": math.nan,
    "inf": math.inf,
    "-1": -1,
    "0": 0,
    "1e-320": 1e-320,
    "1e308": 1e308,
    "empty": [],
    "list with nan": [1.0, math.nan],
    "list": [1.0, 2.0],
    "True": True,
    "complex": 1 + 1j,
}

NO_NUMBERS = {"None", "text", "nan", "inf", "list with nan"}

INNER = frozenset(
    {
        "plate.rectangle",
        "plate.dispersion.frequencies_rad_per_s",
        "plate.modal_sum",
        "plate.propagator",
        "plate.oscillators",
        "plate.ritz",
        "focusing.modulator",
        "focusing.bursts",
    }
)
"""Numerical kernels: their arguments are arrays that the public functions make."""


@dataclass(frozen=True)
class Call:
    """A valid call: what is called, and with what."""

    function: Callable[..., Any]
    arguments: Mapping[str, Any]


def constructors() -> Iterator[tuple[str, object]]:
    """Sound instances, whose fields are the arguments of their classes."""
    yield from {
        "screen.attenuation": Attenuation(3e-3, 0.1),
        "design.closed_forms": ROOM, "finger": (Contactor("soft"),), "fingertip": (Fingertip(10.0),),
        "pulp": (Tissue(), PulpLoad(0.1, 0.1, 6e-3)),
        "design.guide": (Transducers(8), Target(contrast=3.0), DESIGN),
        "focusing.focusing": EMISSION,
        "stimulus.focus_train": (
            TRAIN, TimeReversalStimulus(FOCUS, reversal_s=0.1, heard=FOCUS, path=[0], tau_s=0.1),
        ),
        "plate.glass": Glass("x", 64e9, 0.2, 2230.0, "here"),
        "responses.learning": Excitation(CLICK, 2e3, 0.0, 1e3, "click"),
        "responses.load": (PlateLoad(0.1, 0.1, 10.0), SprungMass(0.1, 0.1, 1e-3, 1e5)),
        "focusing.pattern": (
            Rectangular(), RaisedCosine(), Exponential(), Sinc(), Table((0.0, 1.0)), Pattern(200.0, 0.05),
        ),
        "plate.plate": PLATE, "focusing.quantiser": Analogue(),
        "focusing.one_bit": OneBit(),
        "focusing.sigma_delta": SigmaDelta(), "focusing.pulse_width": PulseWidth(200.0),
        "responses.responses": RESPONSES, "screen.screen": SCREEN,
        "screen.glass_panel": GlassPanel(),
        "stimulus.sensation": (TimeReversalSensation(SETUP), FocusReading(SETUP)), "stimulus.setup": SETUP,
        "focusing.sound": NoiseSpectrum(np.array([10.0, 20.0]), np.array([1e-9, 1e-9])),
        "filters": (BAND, Butterworth(500.0)),
        "design.thickness": SHEETS[0],
        "screen.transducer": (PointForce(0.1, 0.1), Patch(0.1, 0.1, 0.01, 0.01), DiscPatch(0.1, 0.1, 0.01)),
    }.items()  # fmt: skip


def catalogue(folder: Path) -> Mapping[str, Call]:
    """Every valid call by its dotted name, the constructors among them."""
    found = {}
    for module, sound in constructors():
        for each in sound if isinstance(sound, tuple) else (sound,):
            arguments = {field.name: getattr(each, field.name) for field in fields(each)}
            found[f"{module}.{type(each).__name__}"] = Call(type(each), arguments)
    for module, named in calls(folder).items():
        for name, arguments in named.items():
            given = dict(arguments)
            owner = given.pop("self", importlib.import_module(f"{room.__name__}.{module}"))
            member = getattr(owner, name.split(".")[-1]) if "self" in arguments else _reached(owner, name)
            found[f"{module}.{name}"] = Call(member, given)
    return found


def _reached(owner: object, dotted: str) -> Callable[..., Any]:
    for part in dotted.split("."):
        owner = getattr(owner, part)
    return owner


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    return catalogue(tmp_path_factory.mktemp("hostile"))


def public_names() -> Iterator[str]:
    """Dotted names of the functions, of the classes that a person makes, and of their methods."""
    for info in pkgutil.walk_packages(room.__path__, f"{room.__name__}."):
        inner = info.name.removeprefix(f"{room.__name__}.")
        if inner in INNER or inner.startswith("figures") or info.ispkg:
            continue
        module = importlib.import_module(info.name)
        for name, thing in vars(module).items():
            if name.startswith("_") or f"{inner}.{name}" in INNER:
                continue
            if getattr(thing, "__module__", None) == module.__name__:
                yield from _names(f"{inner}.{name}", thing)


def _names(dotted: str, thing: object) -> Iterator[str]:
    if inspect.isfunction(thing):
        yield dotted
    elif is_dataclass(thing) and isinstance(thing, type):
        yield dotted
        for name, member in vars(thing).items():
            if not (name.startswith("_") or hasattr(Effect, name)) and (
                inspect.isfunction(member) or isinstance(member, classmethod)
            ):
                yield f"{dotted}.{name}"


INFINITE = ("focusing.sound.a_weighting_db", "focusing.sound.NoiseSpectrum", "focusing.sound.noise")
"""What their docstrings let be infinite: silence, no weight, no loss, an unknown interval."""

RESULTS = frozenset(
    {
        "responses.plate_constants.Decay", "design.guide.Guide",
        "finger.LossRow", "lift_off.ContactCourse", "lift_off.ContactCourses",
        "responses.load.Receptances", "focus_loss.FocusLoss",
        "responses.measured.Findings", "plate.modes.RitzModes", "plate.modes.SeparableModes",
    }
)  # fmt: skip
"""Classes that functions return and nobody else makes."""


def test_the_catalogue_holds_every_public_function_and_class(known):
    assert set(public_names()) - set(known) == RESULTS


def test_every_call_of_the_catalogue_is_valid(known):
    for name, call in known.items():
        assert not _faults(call.function(**call.arguments), name), name


def test_hostile_arguments_give_a_finite_result_or_one_sentence(known):
    faults = [fault for name, call in known.items() for fault in _tried(name, call)]
    assert not faults, "\n".join(faults)


def _tried(name: str, call: Call) -> Iterator[str]:
    for argument in call.arguments:
        for word, value in HOSTILE.items():
            at, infinite = f"{name}({argument}={word})", word == "inf" or name in INFINITE
            try:
                result = call.function(**{**call.arguments, argument: value})
                yield from (f"{at}: {fault}" for fault in _faults(result, "result", infinite=infinite))
            except TactometryError as error:
                said = str(error)
                named = word not in NO_NUMBERS or argument in said or "cannot be read" in said
                if "\n" in said or not named or not (": found" in said or ": cannot be read (" in said):
                    yield f"{at}: says {said}"
            except Exception as error:
                yield f"{at}: {type(error).__name__}: {error}"


def _faults(result: object, at: str, *, infinite: bool = True) -> list[str]:
    """Numbers that are none, in a result, its fields and its properties."""
    if isinstance(result, (float, complex, np.ndarray, np.generic)) and np.asarray(result).dtype.kind in "fc":
        bad = np.isnan(result) if infinite else ~np.isfinite(result)
        return [f"{at} is {result}"] if np.any(bad) else []
    if isinstance(result, (list, tuple, Iterator)):
        return [fault for part in result for fault in _faults(part, at, infinite=infinite)]
    if is_dataclass(result) and not isinstance(result, type):
        members = [n for n, m in vars(type(result)).items() if isinstance(m, property)] + [
            f.name for f in fields(result)
        ]
        return [fault for n in members for fault in _faults(getattr(result, n), f"{at}.{n}", infinite=infinite)]
    return []
