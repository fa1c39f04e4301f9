"""Invalid values for one argument at a time of every public callable."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
from hostile import complaints, faults, valid_arguments
from time_reversal_calls import calls, constructors

import tactometry.stimuli.time_reversal as room
from tactometry.stimuli.composition.effect import Effect

INNER = {
    "plate.rectangle",
    "plate.dispersion.frequencies_rad_per_s",
    "plate.modal_sum",
    "plate.propagator",
    "plate.oscillators",
    "plate.ritz",
    "focusing.modulator",
    "focusing.bursts",
}
"""Numerical kernels: their arguments are arrays that the public functions make."""


@dataclass(frozen=True)
class Call:
    """A valid call: what is called, and with what."""

    function: Callable[..., Any]
    arguments: Mapping[str, Any]


def catalogue(folder: Path) -> Mapping[str, Call]:
    """Every valid call by its dotted name, the constructors among them."""
    found = {}
    for module, sound in constructors():
        for each in sound if isinstance(sound, tuple) else (sound,):
            found[f"{module}.{type(each).__name__}"] = Call(type(each), valid_arguments(each))
    for module, named in calls(folder).items():
        for name, arguments in named.items():
            given = dict(arguments)
            owner = given.pop("self", importlib.import_module(f"{room.__name__}.{module}"))
            reached = name.rpartition(".")[2] if "self" in arguments else name
            found[f"{module}.{name}"] = Call(attrgetter(reached)(owner), given)
    return found


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


UNBOUNDED = ("a_weighting_db", "a_weighted_db", "noise", "schroeder_db", "tau_s", "t60_s", "stiffness_n_per_m")
"""What may be infinite: silence, a plate without losses, a rigid contact."""

RESULTS = {
    "responses.plate_constants.Decay", "design.guide.Guide",
    "finger.LossRow", "lift_off.ContactCourse", "lift_off.ContactCourses",
    "responses.load.Receptances", "focus_loss.FocusLoss",
    "responses.measured.Findings", "plate.modes.RitzModes", "plate.modes.SeparableModes",
}  # fmt: skip
"""Classes that functions return and nobody else makes."""


def test_the_catalogue_holds_every_public_function_and_class(known):
    assert set(public_names()) - set(known) == RESULTS


def test_every_call_of_the_catalogue_is_valid(known):
    for name, call in known.items():
        assert not list(faults(call.function(**call.arguments), name, UNBOUNDED))


def test_hostile_arguments_give_a_finite_result_or_one_sentence(known):
    found = []
    for name, call in known.items():
        found += complaints(name, call.function, call.arguments, UNBOUNDED)
    assert not found, "\n".join(found)
