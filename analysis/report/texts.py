"""Templates of the report's texts, and number formats."""

from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

import pandas as pd

from ..anova.post_hoc import evidence
from ..wording import in_unit, interval_texts, level_of, number_text, p_text, percent_text, share_text, value_of

if TYPE_CHECKING:
    from jinja2 import Environment

MOST_EVIDENCE = 10_000
"""Larger Bayes factors are printed as "> 10 000"."""


def source(name: str) -> str:
    """Return the text of a file in `templates/`."""
    return (files(__package__) / "templates" / name).read_text("utf-8")


@cache
def environment(*, is_html: bool = False) -> "Environment":
    """Return the template environment, which escapes HTML if `is_html`."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined  # slow to load

    found = Environment(
        loader=FunctionLoader(source),
        autoescape=is_html,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.tests["known"] = pd.notna
    found.filters |= {"p": p_text, "share": share_text, "number": number_text, "percent": percent_text, "df": df_text}
    found.globals |= {"f_text": f_text, "interval": with_interval, "bayes_text": bayes_text, "evidence": evidence}
    found.globals |= {"in_unit": in_unit, "level_of": level_of, "value_of": value_of}
    return found


def lines(template: str, macro: str, *values: object, **named: object) -> list[str]:
    """Return the lines of text that a template macro makes from values."""
    text = str(getattr(environment().get_template(template).module, macro)(*values, **named))
    return [line for line in text.split("\n") if line.strip()]


def paragraph(template: str, **values: object) -> str:
    """Render a template as one paragraph."""
    return " ".join(environment().get_template(template).render(**values).split())


def with_interval(value: float, low: float, high: float, unit: str, level: str = "95 %") -> str:
    """Format a value with its unit and its confidence interval.

    >>> with_interval(-4.8125, -5.21, -4.41, "dB"), with_interval(0.02, -0.3, 0.35, "")
    ('-4.81 dB, 95 % CI [-5.21, -4.41]', '0.020, 95 % CI [-0.300, 0.350]')
    """
    texts = interval_texts(value, low, high)
    return f"{in_unit(texts[0], unit)}, {level} CI [{texts[1]}, {texts[2]}]"


def bayes_text(bf10: float) -> str:
    """Format a Bayes factor.

    >>> bayes_text(0.2312), bayes_text(143.4), bayes_text(4.3e5)
    ('BF10 = 0.23', 'BF10 = 143', 'BF10 > 10 000')
    """
    if bf10 > MOST_EVIDENCE:
        return f"BF10 > {MOST_EVIDENCE:,}".replace(",", " ")  # a comma could be read as a decimal sign
    return f"BF10 = {bf10:.2g}" if bf10 < 10 else f"BF10 = {bf10:.0f}"


def f_text(f: float, first: float, second: float, epsilon: float = 1.0) -> str:
    """Format F with its degrees of freedom, multiplied by `epsilon`.

    >>> f_text(8.1, 2, 14), f_text(8.1, 2, 14, 0.9), f_text(8.1, 1, 10.8)
    ('F(2, 14) = 8.10', 'F(1.80, 12.60) = 8.10', 'F(1, 10.8) = 8.10')
    """
    degrees = f"{first * epsilon:.2f}, {second * epsilon:.2f}" if epsilon < 1 else f"{first:.0f}, {df_text(second)}"
    return f"F({degrees}) = {f:.2f}"


def df_text(df: float) -> str:
    """Format degrees of freedom.

    >>> df_text(9.0), df_text(8.43)
    ('9', '8.4')
    """
    return f"{df:.0f}" if abs(df - round(df)) < 1e-6 else f"{df:.1f}"
