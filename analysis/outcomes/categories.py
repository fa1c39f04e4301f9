"""Answers to questions with choices of their own, as those about a person: how many participants gave each."""

from collections.abc import Iterator

import pandas as pd

from tactometry.questionnaire import ChoiceForm, ChoiceItem
from tactometry.trials.tasks import FORM_TASK

from ..reading.study_file import choices_of
from ..reading.trials import Trials, asked_rows

NOT_SAID = "prefer not to say"
COLUMNS = ("form", "item", "question", "code", "category", "n")


def categories(trials: Trials) -> pd.DataFrame:
    """A row for each category of each question that was asked: `form`, `item`, `question` and `category` in words,
    `code`, and `n` participants, by what each of them answered last. Nothing is tested, and numbers are
    not told."""
    rows = asked_rows(trials)
    if not {"item", "procedure"} <= set(rows.columns):
        return pd.DataFrame(columns=list(COLUMNS))
    forms = choices_of(trials.path)
    rows = rows[(rows["task"] == FORM_TASK) & rows["procedure"].isin(forms)]
    last = rows.drop_duplicates(["participant", "procedure", "item"], keep="last")
    counted = [row for name, answers in last.groupby("procedure") for row in _counts(forms[str(name)], answers)]
    return pd.DataFrame(counted, columns=list(COLUMNS))


def _counts(form: ChoiceForm, answers: pd.DataFrame) -> Iterator[tuple[object, ...]]:
    for item in form.items:
        codes = pd.to_numeric(answers.loc[answers["item"] == item.id, "response"], errors="coerce")
        for code in item.codes if len(codes) and item.options else ():
            words = item.category(code) or NOT_SAID
            yield form.name, item.id, _question(item), code, words, int((codes == code).sum())


def _question(item: ChoiceItem) -> str:
    return item.prompt.get("en", next(iter(item.prompt.values())))
