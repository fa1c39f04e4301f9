"""Procedures as a person calls them. One that has no line here is called by its kind."""

from typing import NamedTuple

REVERSALS, POSTERIOR_MEAN = "mean of the reversals without the first two or three, in even number", "posterior mean"


class ProcedureWords(NamedTuple):
    """A procedure with its article, and what its own estimate is; empty where it has none."""

    phrase: str
    estimate: str = ""


PROCEDURES = {
    "constant_stimuli": ProcedureWords("the method of constant stimuli"),
    "staircase": ProcedureWords("a staircase", REVERSALS),
    "weighted_staircase": ProcedureWords("a weighted staircase", REVERSALS),
    "method_of_limits": ProcedureWords("the method of limits", "mean of the transitions"),
    "quest": ProcedureWords("QUEST", POSTERIOR_MEAN),
    "quest_plus": ProcedureWords("QUEST+", POSTERIOR_MEAN),
    "psi": ProcedureWords("the psi method", POSTERIOR_MEAN),
}


def procedure_phrase(kind: str) -> str:
    """By what levels were chosen.

    >>> procedure_phrase("staircase"), procedure_phrase("stochastic_approximation")
    ('a staircase', 'stochastic approximation')
    """
    return PROCEDURES[kind].phrase if kind in PROCEDURES else kind.replace("_", " ")


def procedure_name(kind: str) -> str:
    """Without its article; a kind that is not ours as the table has it.

    >>> procedure_name("staircase"), procedure_name("their_staircase")
    ('staircase', 'their_staircase')
    """
    return procedure_phrase(kind).removeprefix("a ").removeprefix("the ") if kind in PROCEDURES else kind
