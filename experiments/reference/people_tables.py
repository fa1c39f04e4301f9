"""Reference tables of participants, questionnaires and column maps."""

from collections.abc import Iterator, Mapping
from typing import Final

from tactometry.observers.changes import CHANGES
from tactometry.observers.kinds import OBSERVERS, USUAL

from ..study.kinds import ELECTROVIBRATION, STIMULI
from .study_tables import stimulus_gives
from .tables import KeyTable, Values

_SKIN: Final = "tactometry.stimuli.electrovibration"
_OF_SETUP: Final = ("focus", "measured_focus", "foci", "hybrid")
"""Stimulus kinds, one for each sensation model of a screen."""
_SENSATION: Final[Values] = {
    "finger_x_m": 0.1, "finger_y_m": 0.1, "reference_force_n": 0.05, "polarity": {"positive_share": 0.5}, "x_m": 0.1,
    "y_m": 0.1,
}  # fmt: skip
_OBSERVERS: Final[Mapping[str, Values]] = {"psychometric": {"threshold": 26.0}}
_OF_PEOPLE: Final[Values] = {
    "factor_sd_db": {"force_n": 1.0},
    "effects_db": {"force_n": {"2": 3.0}},
    "correlations": {"sensitivity": {"criterion": 0.3}},
}
_OF_RATERS: Final[Values] = {"loadings": {"PQ1": 0.5}, "effects": {"wave": {"P1": {"PQ": 0.4}}}}


def people_tables() -> Iterator[KeyTable]:
    """Yield the reference tables of sensation, observer and finger."""
    yield KeyTable("sensation", "[sensation]", ELECTROVIBRATION, samples=_SENSATION)
    layer = {"thickness_m": 5e-3}
    yield KeyTable("sensation.skin", "[sensation.skin]", f"{_SKIN}.skin.skin:Skin", samples={"tissue": layer})
    yield KeyTable("sensation.skin.tissue", "[sensation.skin.tissue]", f"{_SKIN}.skin.stack:Layer", example=layer)
    yield from _parts_of_sensation()
    yield from map(_of_screen, _OF_SETUP)
    yield from map(_observer, OBSERVERS)
    people, raters = "tactometry.observers.people:People", "tactometry.observers.raters:Raters"
    yield KeyTable("observer.people", "[observer.people]", people, samples=_OF_PEOPLE)
    yield KeyTable("observer.raters", "[observer.raters]", raters, samples=_OF_RATERS)
    for kind, target in CHANGES.items():
        yield KeyTable(f"observer.changes.{kind}", f"[observer.changes.{kind}]", target)
    yield KeyTable("finger", "[finger]", "tactometry.observers.finger:SimulatedFinger")


def _parts_of_sensation() -> Iterator[KeyTable]:
    attraction, motion = f"{_SKIN}.attraction", f"{_SKIN}.motion"
    targets = {
        "friction": f"{motion}.coulomb_friction:CoulombFriction",
        "lag": f"{motion}.friction_lag:FrictionLag",
        "mobility": f"{motion}.skin_mobility:SkinMobility",
        "polarity": f"{attraction}.polarity:Polarity",
    }
    for name, target in targets.items():
        example = {"positive_share": 0.5} if name == "polarity" else {}
        yield KeyTable(f"sensation.{name}", f"[sensation.{name}]", target, example=example)


def _of_screen(kind: str) -> KeyTable:
    known = STIMULI[kind]
    samples = {**_SENSATION, "fingers": ["index"]}
    given = stimulus_gives(*known.shared)
    return KeyTable(f"sensation.{kind}", "[sensation]", known.sensation, samples=samples, given=given)


def _observer(kind: str) -> KeyTable:
    return KeyTable(
        f"observer.{kind}",
        "[observer]",
        OBSERVERS[kind],
        kind,
        usual=kind == USUAL,
        example=_OBSERVERS.get(kind, {}),
        samples={"conditions": [{"force_n": 0.5, "threshold": 24.0}]},
        also=("observer.people", "observer.raters"),
        in_levels=("threshold", "width"),
    )


_ITEM: Final[Values] = {"id": "rough", "dimension": "rough", "order": 1, "poles": {"en": ["smooth", "rough"]}}
_FORM: Final[Values] = {
    "title": "Roughness",
    "reference": "own wording",
    "low": 0.0,
    "high": 10.0,
    "score_low": 0.0,
    "score_high": 10.0,
    "steps": 11,
    "items": [_ITEM],
    "dimensions": {"rough": {"min_answered": 1}},
}
_WITH_ENDS: Final[Values] = {
    **_FORM,
    "items": [{"id": "rough", "dimension": "rough", "order": 1, "statement": {"en": "It was rough."}}],
    "ends": {"en": ["not at all", "very"]},
}
_OPTIONS: Final = [{"code": 1, "words": {"en": "daily"}}, {"code": 2, "words": {"en": "less often"}}]
_QUESTION: Final[Values] = {"id": "screens", "prompt": {"en": "How often do you use a touch screen?"}}
_CHOICES: Final[Values] = {
    "title": "Habits",
    "reference": "own wording",
    "kind": "choices",
    "items": [{**_QUESTION, "options": _OPTIONS}],
}
_NUMBER: Final[Values] = {**_QUESTION, "low": 18.0, "high": 99.0}


def form_tables() -> Iterator[KeyTable]:
    """Yield the reference tables of inquiries and their forms."""
    inquiry, prompt = "tactometry.experiments.study.study:InquiryTable", {"prompt": "The sheet was ..."}
    yield KeyTable("inquiries", "[inquiries.NAME]", inquiry, example={"form": "sus"}, samples=prompt)
    read, named, forms = "tactometry.questionnaire", lambda: {"name": "own"}, "forms.NAME"
    stem, ends = {"stem": {"en": "The sheet was ..."}}, {"ends": _WITH_ENDS}
    yield KeyTable(
        "forms", f"[{forms}]", f"{read}:Questionnaire", example=_FORM, samples=stem, instead=ends, given=named
    )
    words = {"statement": {"en": "It was rough."}}
    yield KeyTable("forms.items", f"[[{forms}.items]]", f"{read}:Item", example=_ITEM, samples=words)
    titled = {"title": {"en": "Roughness"}, "parts": ["rough"]}
    dimension = {"min_answered": 1}
    yield KeyTable(
        "forms.dimensions", f"[{forms}.dimensions.NAME]", f"{read}:Dimension", example=dimension, samples=titled
    )
    yield KeyTable("forms.choices", f"[{forms}]", f"{read}:ChoiceForm", example=_CHOICES, given=named)
    question, bounds = {**_QUESTION, "options": _OPTIONS}, {"low": _NUMBER, "high": _NUMBER}
    header = f"[[{forms}.items]]"
    yield KeyTable("forms.choices.items", header, f"{read}:ChoiceItem", example=question, instead=bounds)
    header = f"[[{forms}.items.options]]"
    yield KeyTable("forms.choices.items.options", header, f"{read}:Option", example=_OPTIONS[0])


_SAMPLES: Final[Values] = {
    "columns": {"participant": "subject", "latency_s": "rt"},
    "constants": {"task": "yes_no"},
    "values": {"response": {"y": 1, "n": 0}},
    "keep": {"event": ["response"]},
    "from_name": {"participant": "sub"},
    "units": {"latency_s": "ms"},
    "level_scale": "log10",
    "missing": ["NA"],
}


def map_tables() -> Iterator[KeyTable]:
    """Yield the reference table of a column map. Users choose its keys."""
    yield KeyTable("map", "", "tactometry.analysis.reading.column_map:ColumnMap", samples=_SAMPLES)
