"""The tables of a questionnaire, and of questions about a person, in a study or in files of their own."""

from collections.abc import Callable, Iterator
from typing import Final

from .key_table import KeyTable, Values

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
    """The tables of inquiries and of what they ask."""
    inquiry, prompt = "tactometry.experiments.study.study:InquiryTable", {"prompt": "The sheet was ..."}
    yield KeyTable("inquiries", "[inquiries.NAME]", inquiry, example={"form": "sus"}, samples=prompt)
    read, named, forms = "tactometry.questionnaire", _named("own"), "forms.NAME"
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
    choices = "tactometry.choice_form"
    yield KeyTable("forms.choices", f"[{forms}]", f"{choices}:ChoiceForm", example=_CHOICES, given=named)
    question, bounds = {**_QUESTION, "options": _OPTIONS}, {"low": _NUMBER, "high": _NUMBER}
    header = f"[[{forms}.items]]"
    yield KeyTable("forms.choices.items", header, f"{choices}:ChoiceItem", example=question, instead=bounds)
    header = f"[[{forms}.items.options]]"
    yield KeyTable("forms.choices.items.options", header, f"{choices}:Option", example=_OPTIONS[0])


def _named(name: str) -> Callable[[], Values]:
    return lambda: {"name": name}
