"""Numbers of participants by answer to categorical questions."""

from collections.abc import Iterator

import pandas as pd

from tactometry.questionnaire import ChoiceForm
from tactometry.trials.tasks import FORM_TASK

from ..reading.study_file import choices_of
from ..reading.trials import Trials, asked_rows

NOT_SAID = "prefer not to say"
COLUMNS = ("form", "item", "question", "code", "category", "n")


def categories(trials: Trials) -> pd.DataFrame:
    """Return numbers of participants by question and category."""
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
            question = item.prompt.get("en", next(iter(item.prompt.values())))
            yield form.name, item.id, question, code, item.category(code) or NOT_SAID, int((codes == code).sum())
