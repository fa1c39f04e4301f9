"""Argument checks by annotation, by the unit in a name and by `require`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, nan
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from annotated_types import Ge, Interval
from numpy.typing import ArrayLike, NDArray

from tactometry.arguments import require
from tactometry.arguments.checked import (
    Matrix,
    NotNegative,
    NotNegativeArray,
    Positive,
    PositiveArray,
    PositiveWhole,
    Unbounded,
    UnboundedArray,
    Vector,
    checked,
)
from tactometry.arguments.constraints import Finite, Rate, Share, constrained
from tactometry.arguments.require import UNLIMITED, Unlimited
from tactometry.errors import InvalidParameter

SENTENCES: Mapping[str, tuple[Any, Any, str]] = {
    "a number": (float, "wide", "found 'wide', expected a finite number"),
    "no NaN": (float, nan, "found nan, expected a finite number"),
    "no infinity": (float, inf, "found inf, expected a finite number"),
    "no truth value": (float, True, "found True, expected a finite number"),
    "in the domain of its unit": (float, 1e10, "found 10000000000.0, expected a number of at most 1e+09"),
    "a number or infinity": (Unbounded, nan, "found nan, expected a number"),
    "numbers": (ArrayLike, [[1.0, nan]], "[0, 1]: found nan, expected a finite number"),
    "numbers or infinity": (UnboundedArray, [inf, nan], "[1]: found nan, expected a number"),
    "an array": (NDArray[np.float64], 1.0, "found 1.0, expected an array of finite numbers"),
    "one dimension": (Vector, [[1.0]], "found shape (1, 1), expected an array in 1 dimension of finite numbers"),
    "at least one": (Vector, [], "found shape (0,), expected an array in 1 dimension of finite numbers, at least one"),
    "two dimensions": (Matrix, [1.0], "found shape (1,), expected an array in 2 dimensions of finite numbers"),
    "a number above 0": (Positive, 0.0, "found 0.0, expected a finite number above 0"),
    "a count above 0": (PositiveWhole, 0, "found 0, expected a finite number above 0"),
    "a number above 0, or None": (Positive | None, -1.0, "found -1.0, expected a finite number above 0"),
    "a number of at least 0": (NotNegative, -1.0, "found -1.0, expected a finite number, at least 0"),
    "numbers above 0": (PositiveArray, [1.0, 0.0], "[1]: found 0.0, expected a finite number above 0"),
    "numbers of at least 0": (NotNegativeArray, [0.0, -1.0], "[1]: found -1.0, expected a finite number, at least 0"),
    "a list of numbers": (tuple[float, ...], (1.0, "a"), "[1]: found 'a', expected a finite number"),
    "a list of points": (Sequence[tuple[float, float]], [(0.0,)], "[0]: found (0.0,), expected (a finite number, "),
    "a mapping": (Mapping[str, float], {"a": nan}, "['a']: found nan, expected a finite number"),
    "a whole number": (int, 1.5, "found 1.5, expected a whole number"),
    "a truth value": (bool, 1, "found 1, expected True or False"),
    "a class or None": (range | None, 3, "found 3, expected a range or None"),
    "a word": (Literal["sine", "square"], "sin", "found 'sin', expected one of sine, square; did you mean 'sine'?"),
    "a function": (Callable[[float], float], 3, "found 3, expected a function"),
}


def taking(annotation: Any) -> Callable[..., Any]:
    def same(x_m, *, y_m=None):
        return x_m if y_m is None else y_m

    same.__annotations__ = {"x_m": annotation, "y_m": annotation | None if annotation is float else annotation}
    same.__qualname__ = "same"
    return checked(same)


@pytest.mark.parametrize(("annotation", "value", "sentence"), SENTENCES.values(), ids=SENTENCES)
def test_arguments_outside_their_annotation_are_refused(annotation, value, sentence):
    expected = f"same.x_m{'' if sentence.startswith('[') else ': '}{sentence}"
    with pytest.raises(InvalidParameter) as caught:
        taking(annotation)(value)
    assert str(caught.value).startswith(expected)


@pytest.mark.parametrize(
    ("annotation", "value"),
    [
        (Unbounded, -inf), (UnboundedArray, [1.0, inf]), (float, np.float32(2)), (float, 3), (ArrayLike, []),
        (Mapping[str, float], {}), (range | None, None), (Any, "anything"), (tuple[float, ...], ()), (complex, 1j),
    ],
)  # fmt: skip
def test_arguments_within_their_annotation_are_passed_unchanged(annotation, value):
    assert taking(annotation)(value) is value


def test_list_arguments_are_converted_to_arrays():
    same = taking(Vector)
    assert isinstance(same([1, 2]), np.ndarray)
    assert same([1.0], y_m=(3, 4)).tolist() == [3.0, 4.0]


def test_too_many_arguments_raise_type_error():
    with pytest.raises(TypeError, match="positional"):
        taking(Vector)([1.0], [2.0])


@checked
@dataclass(frozen=True)
class Rod:
    length_m: float

    def cut(self, at_m: float) -> float:
        return self.length_m - at_m

    @classmethod
    def of(cls, lengths_m: Vector) -> "Rod":
        return cls(float(lengths_m.sum()))


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: Rod("long"), "Rod.length_m"),
        (lambda: Rod(length_m=nan), "Rod.length_m"),
        (lambda: Rod(1.0).cut("short"), "Rod.cut.at_m"),
        (lambda: Rod.of([1.0, nan]), r"Rod.of.lengths_m\[1\]"),
    ],
)
def test_class_checks_arguments_of_constructor_and_methods(call, name):
    with pytest.raises(InvalidParameter, match=f"^{name}: found .*, expected a finite number$"):
        call()


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: require.positive("Rod", length_m=0), "Rod.length_m: found 0, expected a finite number above 0"),
        (lambda: require.positive("Rod", length_m=1e10), "found 10000000000.0, expected a number from 1e-20 to 1e+09"),
        (lambda: require.positive("Rod", length_m=1e-320), "found 1e-320, expected a number from 1e-20 to 1e+09"),
        (lambda: require.not_negative("Rod", length_m=-1), "found -1, expected a finite number, at least 0"),
        (lambda: require.not_negative("Rod", length_m=1e-30), "expected 0 or a number from 1e-20 to 1e+09"),
        (lambda: require.finite("Rod", at=10**400), f"Rod.at: found {10**59}, expected a finite number"),
        (lambda: require.between("Rod", 0, 1, part=1), "Rod.part: found 1, expected a number above 0 and below 1"),
        (lambda: require.whole("Rod", n=2**40), "found 1099511627776, expected a whole number, at most 2147483648"),
        (lambda: require.whole("Rod", lowest=1, n=True), "Rod.n: found True, expected a whole number, at least 1"),
        (lambda: require.truth("Rod", bent=1), "Rod.bent: found 1, expected True or False"),
        (lambda: require.of_kind("Rod", (range, type(None)), at=1), "Rod.at: found 1, expected a range or None"),
        (lambda: require.positive_array("Rod.at_m", [1.0, 0.0]), "at_m[1]: found 0.0, expected a finite number above"),
        (lambda: require.not_negative_array("at_m", inf), "at_m: found inf, expected a finite number, at least 0"),
        (lambda: require.ascending("at_m", [1.0, 1.0]), "expected two or more ascending numbers"),
        (lambda: require.one_of("kind", 1, (2, 3)), "kind: found 1, expected one of 2, 3"),
        (lambda: require.lookup("kind", "hnad", {"hand": 1}), "found 'hnad', expected one of hand; did you mean 'hand"),
        (lambda: require.below_1("Rod", part=1.0), "Rod.part: found 1.0, expected a number from 0 to below 1"),
        (lambda: require.within("Rod", 0, 1, part=1.5), "Rod.part: found 1.5, expected a number from 0 to 1"),
        (lambda: require.not_zero("Rod", tilt=0.0), "Rod.tilt: found 0.0, expected a finite nonzero number"),
        (lambda: require.at_most("modes", 2e6, 1e6), "modes: found 2e+06, expected at most 1e+06"),
        (lambda: require.distinct("steps", (4.0, 2, 4), "each once"), "steps[2]: found 4 twice, expected each once"),
        (lambda: require.finite_array("at_v", [0.0, 1e200]), "at_v[1]: found 1e+200, expected a number of at most 1e+"),
        (lambda: require.shape("field_m", [1.0, 2.0], (3,)), "field_m: found shape (2,), expected (3)"),
    ],
)  # fmt: skip
def test_require_functions_refuse_in_one_sentence(call, sentence):
    with pytest.raises(InvalidParameter) as caught:
        call()
    assert sentence in str(caught.value)


def test_infinity_is_accepted_when_allowed():
    assert require.not_negative_array("reversal_s", [0.0, inf], infinite=True).tolist() == [0.0, inf]
    assert float(require.positive_array("repetition_s", inf, infinite=True)) == inf


@dataclass(frozen=True)
@constrained
class Bar:
    length_m: Positive = 1.0
    mass_kg: NotNegative = 0.0
    tilt: Finite = 0.0
    duty: Share = 0.0
    lapse_rate: Rate = 0.0
    n_holes: Annotated[int, Interval(ge=1, le=9)] = 1
    age_days: Annotated[int, Ge(0)] | Unlimited | None = None
    part: Annotated[float, Interval(gt=0, le=1)] = 1.0
    gains_db: dict[str, dict[str, Finite]] = field(default_factory=dict)
    holes_m: tuple[Positive, ...] = ()

    def __post_init__(self) -> None:
        require.below("Bar", mass_kg=self.mass_kg, limit=10.0)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"length_m": -1}, "Bar.length_m: found -1, expected a finite number above 0"),
        ({"length_m": None}, "Bar.length_m: found None, expected a finite number above 0"),
        ({"length_m": 1e10}, "Bar.length_m: found 10000000000.0, expected a number from 1e-20 to 1e+09"),
        ({"mass_kg": True}, "Bar.mass_kg: found True, expected a finite number, at least 0"),
        ({"mass_kg": 11.0}, "Bar.mass_kg: found 11, expected less than limit (10)"),
        ({"tilt": inf}, "Bar.tilt: found inf, expected a finite number"),
        ({"duty": 1.5}, "Bar.duty: found 1.5, expected a number from 0 to 1"),
        ({"lapse_rate": 1.0}, "Bar.lapse_rate: found 1.0, expected a number from 0 to below 1"),
        ({"n_holes": 0}, "Bar.n_holes: found 0, expected a whole number, at least 1"),
        ({"n_holes": 10}, "Bar.n_holes: found 10, expected a whole number, at most 9"),
        ({"age_days": -1}, "Bar.age_days: found -1, expected a whole number, at least 0"),
        ({"part": 0.0}, "Bar.part: found 0.0, expected a number above 0 and at most 1"),
        ({"gains_db": {"a": {"b": nan}}}, "Bar.gains_db.a.b: found nan, expected a finite number"),
        ({"holes_m": (1.0, 0.0)}, "Bar.holes_m[1]: found 0.0, expected a finite number above 0"),
    ],
)
def test_dataclass_refuses_field_outside_its_constraint(values, sentence):
    with pytest.raises(InvalidParameter) as caught:
        Bar(**values)
    assert str(caught.value) == sentence


@pytest.mark.parametrize("age_days", [None, UNLIMITED, 3])
def test_constraint_of_union_ignores_values_of_other_classes(age_days):
    assert Bar(age_days=age_days, mass_kg=0).age_days is age_days
