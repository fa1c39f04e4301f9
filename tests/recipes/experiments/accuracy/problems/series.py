"""Terms of an alternating series, against its limit."""

import math
from functools import partial

from ..measure import Problem, Reference, Setting

N_TERMS = (1, 10, 100, 1000)


def problem() -> Problem:
    """Leibniz: a quarter of pi."""
    return Problem(
        "relative error of pi, by the terms of Leibniz's series",
        reference=Reference("the constant of the standard library", lambda: math.pi, 1e-15),
        error=lambda answer, reference: abs(answer / reference - 1),
        settings=tuple(Setting(f"{n} terms", partial(_sum, n), float(n)) for n in N_TERMS),
        price="terms",
    )


def _sum(n: int) -> float:
    return 4 * sum((-1) ** k / (2 * k + 1) for k in range(n))
