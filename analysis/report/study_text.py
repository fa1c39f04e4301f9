"""Title and procedure of a study, written from its file."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactometry.config.quantity import as_si
from tactometry.config.toml import errors_in, read_table

from ..reading.level_scale import SETTINGS
from ..reading.origin import StudyText
from ..tasks.kinds import ANALYSES
from ..wording import in_words, level_of, percent_text, procedure_phrase, split_unit
from .texts import paragraph

Table = Mapping[str, Any]
STIMULI = {
    "amplitude_modulated": "amplitude-modulated electrovibration",
    "sine": "electrovibration with a sinusoidal voltage",
    "focus": "a time-reversal focus",
    "pattern": "a pattern of time-reversal foci",
    "hybrid": "simultaneous time-reversal foci and electrovibration",
    "measured_focus": "a time-reversal focus, measured by a vibrometer",
    "foci": "time-reversal foci under one or more fingers",
    "square": "electrovibration with a square-wave voltage",
    "triangle": "electrovibration with a triangle-wave voltage",
    "pulse_train": "electrovibration with voltage pulses",
    "trapezoid": "electrovibration with a trapezoidal voltage",
    "step": "a voltage step on an electrovibration surface",
    "texture": "a texture rendered by electrovibration",
    "wav": "a signal from a file",
}
WORDS = {
    "catch_rate": "share of catch trials",
    "easy_level": "level of easy trials",
    "easy_share": "share of easy trials",
    "form": "questionnaire",
    "high": "highest level",
    "hold_s": "force held before each stimulus",
    "low": "lowest level",
    "n_alternatives": "alternatives",
    "n_attempts": "maximum number of attempts per trial",
    "n_correct": "correct answers needed",
    "n_down": "correct answers before a lower level",
    "n_intervals": "intervals",
    "n_of": "among the last",
    "n_reversals": "reversals",
    "n_touches": "touches before each rating",
    "n_trials": "maximum number of trials",
    "n_up": "incorrect answers before a higher level",
    "ramp_s": "ramps",
    "repeats": "presentations of each level",
    "rest_after": "trials before a rest",
    "shared": "all parameters except the threshold shared by interleaved tracks",
    "start": "first level",
    "tolerance": "force tolerance",
    "timeout_s": "time limit for a touch",
    "width_high": "largest width",
    "width_low": "smallest width",
    "voltage_peak_v": "maximum peak voltage",
}
"""Descriptions of keys whose names are not self-explanatory."""
SHARES = ("catch_rate", "easy_share", "tolerance", "speed_tolerance")
LEVELS = ("levels", "start", "easy_level", "low", "high", "standard_level")


def study_text(path: Path, unit: str) -> StudyText:
    """Return title, procedure and force of a folder's study.

    Raises `InvalidFile` if the study cannot be read.
    """
    file = path / "study.toml"
    if not file.is_file():
        return StudyText()
    study = read_table(file, "the study that ran")
    with errors_in(file):
        touch = as_si(dict(_table(study, "touch")), "touch")
    force = touch.get("force_n") if isinstance(touch, dict) else None
    if not isinstance(force, int | float) or "force_n" in _table(study, "factors"):
        force = None
    return StudyText(str(study.get("title", "")), procedure_text(study, unit), force)


def procedure_text(study: Table, unit: str) -> str:
    """Return the procedure of a study as a paragraph.

    >>> print(procedure_text({
    ...     "factors": {"frequency_hz": [60, 240]}, "counterbalance": ["frequency_hz"],
    ...     "touch": {"kind": "slide", "force_n": 1.0, "speed_m_per_s": "50 mm/s"},
    ...     "task": {"kind": "yes_no", "catch_rate": 0.2},
    ...     "procedure": {"kind": "staircase", "start": 40.0, "n_reversals": 8},
    ... }, "dB re 1 V"))
    The conditions were frequency (60, 240 Hz). The order of frequency was balanced over participants by Williams
    squares. Touches were slides over the surface (force 1 N, speed 50 mm/s). Participants reported whether they felt a
    stimulus (share of catch trials 20 %). Levels were chosen by a staircase (first level 40 dB re 1 V, reversals 8).
    """
    factors, plan = _table(study, "factors"), _table(study, "plan")
    orders = dict(_table(plan, "orders"))
    orders["williams"] = [*study.get("counterbalance", ()), *orders.get("williams", ())]
    text = paragraph(
        "study.j2",
        study=study,
        unit=unit,
        conditions=[f"{split_unit(name)[0]} ({_levels(name, levels)})" for name, levels in factors.items()],
        plan={key: plan.get(key) for key in ("between", "sessions", "interleave")},
        orders=orders,
        stimuli=STIMULI,
        courses={name: task.course for name, task in ANALYSES.items()},
        is_setting=_table(study, "task").get("kind") in SETTINGS,
        procedure_phrase=procedure_phrase,
        names=_names,
        enumerated=_enumeration,
        table_of=_table,
        details=_details,
    )
    return in_words(text, list(factors))


def _table(study: Table, name: str) -> Table:
    """Return a table of the (unvalidated) file, or an empty one."""
    table = study.get(name, {})
    return table if isinstance(table, Mapping) else {}


def _names(factors: Sequence[str]) -> str:
    return _enumeration([split_unit(str(name))[0] for name in factors])


def _enumeration(parts: Sequence[str]) -> str:
    """Join parts with commas and "and".

    >>> _enumeration(["a"]), _enumeration(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def _levels(name: str, stated: Any) -> str:
    """Format the levels of a factor with their unit.

    >>> _levels("force_n", [0.5, 3.0]), _levels("speed_m_per_s", ["50 mm/s"]), _levels("pattern", ["P0", "P1"])
    ('0.5, 3 N', '50 mm/s', 'P0, P1')
    """
    levels = stated if isinstance(stated, list) else [stated]
    if any(isinstance(level, str) for level in levels):
        return ", ".join(str(level).replace("_", " ") for level in levels)
    unit = split_unit(name)[1]
    return ", ".join(f"{level:g}" for level in levels) + (f" {unit}" if unit else "")


def _details(table: Table, unit: str) -> str:
    """Return the keys of a table in brackets.

    >>> _details({"kind": "press", "force_n": 1.5, "hold_s": "300 ms"}, "")
    ' (force 1.5 N, force held before each stimulus 300 ms)'
    """
    keys = ", ".join(_detail(key, value, unit) for key, value in table.items() if key != "kind")
    return f" ({keys})" if keys else ""


def _detail(key: str, value: Any, unit: str) -> str:
    """Describe a key of a table and its value.

    >>> _detail("tolerance", 0.2, ""), _detail("levels", [12, 16], "dB re 1 um"), _detail("feedback", True, "")
    ('force tolerance 20 %', 'levels 12, 16 dB re 1 um', 'feedback')
    """
    words = WORDS.get(key, re.sub("^n ", "number of ", split_unit(key)[0]))
    if isinstance(value, bool):
        return words if value else f"no {words}"
    if isinstance(value, Mapping):
        return f"{words}{_details(value, unit)}"
    if key in SHARES and isinstance(value, int | float):
        return f"{words} {percent_text(value)}"
    # A text already contains its unit. Steps in decibels are ratios, so the reference is dropped.
    stated = _levels(key, value) if isinstance(value, list) else level_of("" if isinstance(value, str) else key, value)
    suffix = unit if key in LEVELS else unit.partition(" re ")[0] if key == "steps" else ""
    return f"{words} {stated} {suffix}".rstrip()
