"""Export to one table for R, JASP or jamovi, with a script that reads it.

Missing values are NA. The script contains a mixed model for each task. `r_string` escapes its names and texts.
"""

from collections.abc import Iterator, Sequence

import pandas as pd

from tactometry.analysis.tasks.cells import alternatives
from tactometry.analysis.tasks.kinds import ANALYSES
from tactometry.analysis.tasks.task_analysis import R_OF_FORM
from tactometry.files.rows import cell_text, spreadsheet_text
from tactometry.questionnaire import Questionnaire
from tactometry.trials.cells import cell
from tactometry.trials.columns import ALWAYS, FIRST, OPTIONAL
from tactometry.trials.row_rules import COUNTS, FLAGS, NUMBERS

from .source import ExportedDataSet

TEXT = {column.name for column in (*FIRST, *ALWAYS, *OPTIONAL)}.difference(NUMBERS, COUNTS, FLAGS)
MOST_CATEGORIES = 15
"""Scales with more answer categories are modelled as continuous."""
SCRIPT = """# Reads trials.csv with its types. Written by tactometry export --to r.
trials <- read.csv("trials.csv", na.strings = "NA", stringsAsFactors = FALSE, check.names = FALSE,
                   encoding = "UTF-8", colClasses = c({classes}))
trials$participant <- factor(trials$participant)
used <- subset(trials, {used})
{factors}{forms}
# A model for each task begins so:
{models}
"""
FORM = """
# {title}: answers to reversed items are turned around.
{name} <- subset(used, procedure == {text})
{name} <- transform(
  {name}, response = ifelse(item %in% c({turned}), {sum:g} - as.numeric(response), as.numeric(response)))
"""
CONTINUOUS = "lme4::lmer(response ~ {plus} + (1 | participant) + (1 | item), {data})"


def r_files(source: ExportedDataSet) -> dict[str, bytes]:
    """Return `trials.csv` and `trials.R`. Equal data give equal bytes."""
    names = [column.name for column in source.columns]
    ordered = [row for _, _, rows in source.sessions() for row in rows]
    body = [[row.get(name) or "NA" for name in names] for row in ordered]
    return {"trials.csv": spreadsheet_text([names, *body]), "trials.R": _script(source, names).encode()}


def r_string(text: str) -> str:
    r"""Return any text as an R string literal on one line.

    >>> print(r_string('a "b"'), r_string("x" + chr(10) + "y"))
    "a \"b\"" "x\u{a}y"
    """
    return f'"{_escape(text, chr(34))}"'


def name(text: str) -> str:
    r"""Return a column name quoted for a formula.

    >>> print(name("force_n"), name("x; system('rm')"), name("a`b"))
    `force_n` `x; system('rm')` `a\`b`
    """
    return f"`{_escape(text, '`')}`"


def _escape(text: str, quote: str) -> str:
    signs = {"\\": "\\\\", quote: f"\\{quote}"}
    return "".join(signs.get(sign, sign if sign.isprintable() else f"\\u{{{ord(sign):x}}}") for sign in text)


def _script(source: ExportedDataSet, names: Sequence[str]) -> str:
    textual = {factor for factor in source.factors if not _is_number(source, factor)}.union(TEXT)
    kinds = ",\n      ".join(
        f'{r_string(cell_text(column))} = "{"character" if column in textual else "numeric"}"' for column in names
    )
    conditions = ["!is.na(response)"]
    conditions += ["valid == 1"] if "valid" in names else []
    conditions += [f"(is.na({flag}) | {flag} != 1)" for flag in ("practice", "catch") if flag in names]
    columns = [r_string(cell_text(factor)) for factor in source.factors]
    return SCRIPT.format(
        classes=kinds,
        used=" & ".join(conditions),
        factors="".join(f"used[[{column}]] <- factor(used[[{column}]])\n" for column in columns),
        forms="".join(_form(form) for form in source.forms.values()),
        models="\n".join(f"# {model}" for model in _models(source)),
    )


def _form(form: Questionnaire) -> str:
    return FORM.format(
        title=" ".join(form.title.split()),
        name=name(form.name),
        text=r_string(cell_text(form.name)),
        turned=", ".join(r_string(cell_text(item.id)) for item in form.items if item.reversed),
        sum=form.low + form.high,
    )


def _models(source: ExportedDataSet) -> Iterator[str]:
    """Yield a model for each task and each questionnaire."""
    scored = source.used["procedure"].isin(source.asked) if source.asked else pd.Series(False, source.used.index)
    for task in source.tasks():
        rows = source.used[(source.used["task"] == task) & ~scored]
        if len(rows):
            is_alone = source.tasks() == [task] and not scored.any()
            of_task = () if is_alone else (f"task == {r_string(task)}",)
            numbers = alternatives(rows, source.factors)
            for number, alike in rows.groupby(numbers):
                of_number = of_task if numbers.nunique() == 1 else (*of_task, _conditions(alike, source.factors))
                data = f"subset(used, {' & '.join(of_number)})" if of_number else "used"
                yield _fill_model(ANALYSES[task].r_model, alike, source, data, int(number))
    for form in source.forms.values():
        rows = source.used[scored & (source.used["procedure"] == form.name)]
        is_continuous = form.steps is None or form.steps > MOST_CATEGORIES
        yield _fill_model(CONTINUOUS if is_continuous else R_OF_FORM, rows, source, name(form.name))


def _conditions(rows: pd.DataFrame, factors: Sequence[str]) -> str:
    values = rows[list(factors)].drop_duplicates().itertuples(index=False, name=None)
    each = (
        " & ".join(f"{name(cell_text(key))} == {r_string(cell(at))}" for key, at in zip(factors, of, strict=True))
        for of in values
    )
    return f"({' | '.join(each)})"


def _fill_model(model: str, rows: pd.DataFrame, source: ExportedDataSet, data: str, n_choices: int = 2) -> str:
    varied = [name(cell_text(factor)) for factor in source.factors if rows[factor].nunique() > 1]
    times, plus = "".join(f" * {factor}" for factor in varied), " * ".join(varied) or "1"
    return model.format(times=times, plus=plus, data=data, n_choices=n_choices)


def _is_number(source: ExportedDataSet, name: str) -> bool:
    try:
        # A column without values counts as text.
        return bool([float(text) for row in source.rows if (text := row.get(name))])
    except ValueError:
        return False
