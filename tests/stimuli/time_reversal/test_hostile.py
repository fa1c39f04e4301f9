"""Invalid values for one argument at a time of every public callable."""

import pytest
from hostile import complaints, faults
from time_reversal_calls import calls

UNBOUNDED = ("a_weighting_db", "a_weighted_db", "noise", "schroeder_db", "tau_s", "t60_s", "stiffness_n_per_m")
"""Quantities that may be infinite: of silence, of a plate without losses, of a rigid contact."""


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    return calls(tmp_path_factory.mktemp("hostile"))


def test_every_public_callable_has_a_valid_call(known):
    for name, call in known.items():
        assert not list(faults(call.function(**call.arguments), name, UNBOUNDED)), name


def test_hostile_arguments_give_finite_result_or_one_sentence(known):
    found = []
    for name, call in known.items():
        found += complaints(name, call.function, call.arguments, UNBOUNDED)
    assert not found, "\n".join(found)
