"""Names of physical quantities end in their SI unit, as `force_n`."""

import ast
import re
from collections.abc import Iterator

import pytest
from source_tree import name_of, parsed, sources

WORDS = """
acceleration amplitude angle area attenuation bandwidth capacitance carrier charge conductance
current cutoff delay density depth diameter displacement distance duration energy force frequency
gap impedance impulse inductance jitter latency length mass modulus moment offset onset period
phase position power pressure radius rate resistance resistivity rigidity speed
stiffness stress tau temperature tension thickness time timeout torque velocity viscosity voltage
volume wavelength width
"""
QUANTITIES = frozenset(WORDS.split())
UNIT = r"(?:s|hz|n|v|a|m|kg|pa|ohm|f|c|w|j|k|rad|cd|t|[sm][234]|v2|hz2|n2)"
RATIOS = frozenset(("ratio", "factor", "exponent", "fraction", "share", "loss", "cv", "coefficient", "gain", "to"))
SUFFIX = re.compile(rf"_(?:{UNIT}(?:_{UNIT})*(?:_per(?:_{UNIT})+)*|per(?:_{UNIT})+|(?:db|dba)(?:_re_\w+)?)(?:_at)?$")
PREFIXED = re.compile(r"_(?:ms|us|khz|mhz|mm|um|nm|cm|mn|kn|kv|mv|ma|kpa|mpa|gpa|g|mg|deg|percent)$")

BARE = {
    "guess_rate": "a probability",
    "summed_amplitude": "of the event that is felt as strongly as a train, in the unit of its peaks",
    "lapse_rate": "a probability",
    "catch_rate": "a share of trials",
    "return_rate": "a probability",
    "false_alarm_rate": "a probability",
    "lapse_beta": "a parameter of a beta distribution",
    "guess_beta": "a parameter of a beta distribution",
    "log_rate_mass": "of a density of a rate",
    "force_in_band": "a share of samples; the pinned name of a column",
    "positions_late": "a share of samples; the name of a column",
    "speed_in_band": "a share of samples; the pinned name of a column",
    "width": "of a psychometric function, in the unit of its level; a pinned name",
    "widths": "of psychometric functions, in the unit of their level",
    "guess_rates": "probabilities",
    "lapse_rates": "probabilities",
    "rate_correct": "a share of trials",
    "speed_tolerance": "relative to a speed",
    "system_volume": "of a sound server, 1 for 100 %",
    "width_low": "the lower bound of that width",
    "width_high": "the upper bound of that width",
    "z_width": "of a standard shape: a number",
    "amplitudes": "of the components of a record, in the unit of the record",
    "focus_amplitude": "in the unit of the responses",
    "focus_amplitudes": "in the unit of the responses",
    "tuft_depth": "a share of a force",
    "phase": "a position in a cycle, 0 to 1",
    "phases": "positions in a cycle, 0 to 1",
    "power": "of a test: a probability",
    "power_low": "the lower bound of that power",
    "power_high": "the upper bound of that power",
    "width_in": "of a figure, in inches, which matplotlib takes",
}
DRAWN = tuple(f"tactometry/rigs/{name}.py" for name in ("pages/layout", "pages/page", "drawing", "window"))
ON_SCREEN = frozenset(("width", "length", "radius", "position"))  # PsychoPy's unit: heights of the window


def holds_float(annotation: ast.expr | None) -> bool:
    return annotation is not None and "float" in ast.unparse(annotation)


def arguments(function: ast.FunctionDef) -> Iterator[str]:
    yield from (arg.arg for arg in (*function.args.args, *function.args.kwonlyargs) if holds_float(arg.annotation))


def float_names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and name of each public float field, argument or function."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield from ((node.lineno, name) for name in arguments(node))
            if holds_float(node.returns):
                yield node.lineno, node.name
        if isinstance(node, ast.ClassDef):
            fields = (part for part in node.body if isinstance(part, ast.AnnAssign) and holds_float(part.annotation))
            yield from ((part.lineno, part.target.id) for part in fields if isinstance(part.target, ast.Name))


def stems(name: str) -> set[str]:
    words = set(name.split("_"))
    return words | {re.sub("ies$", "y", word) for word in words} | {word.removesuffix("s") for word in words}


def lacks_unit(name: str, bare: frozenset[str]) -> bool:
    if name in BARE or name.startswith("n_") or RATIOS & stems(name):
        return False
    return bool(PREFIXED.search(name)) or (not SUFFIX.search(name) and bool((QUANTITIES - bare) & stems(name)))


def offences(tree: ast.AST, bare: frozenset[str] = frozenset()) -> list[str]:
    return [f"{line}: {name}" for line, name in float_names(tree) if lacks_unit(name, bare)]


WITHOUT = "force max_force forces frequencies duration_ms speed_mm skin_resistance phase_deg tau"


@pytest.mark.parametrize("name", WITHOUT.split(" "))
@pytest.mark.parametrize(
    "source", ["class A:\n    {}: float", "def f(*, {}: float | None) -> None: ...", "def {}() -> float: ..."]
)
def test_a_quantity_without_its_si_unit_is_found(name: str, source: str) -> None:
    assert [offence.split(": ")[1] for offence in offences(ast.parse(source.format(name)))] == [name]


WITH_UNITS = """
force_n forces_n speed_m_per_s level voltage_db_re_1v area_m2 resistivity_ohm_m density_kg_per_m3
point_impedance_n_s_per_m lapse_rate rate_hz rate_per_s force_cv
"""


@pytest.mark.parametrize("name", WITH_UNITS.split())
def test_a_name_with_its_unit_passes(name: str) -> None:
    assert offences(ast.parse(f"def f({name}: float) -> None: ...")) == []


def test_every_public_quantity_carries_its_si_unit() -> None:
    lacking = [
        f"{name_of(path)}:{offence}"
        for path in sources()
        for offence in offences(parsed(path), ON_SCREEN if name_of(path) in DRAWN else frozenset())
    ]
    assert lacking == [], "add the unit, or explain the name in BARE"
