"""A data set as one table for R, JASP or jamovi: NA for what was not measured, and a script that reads it."""

from tactometry.experiments.export_source import Source, separated

TEXT = (
    "participant",
    "study",
    "procedure",
    "level_unit",
    "task",
    "timestamp_utc",
    "track",
    "item",
    "item_b",
    "response",
    "rig",
    "invalid_reason",
)
SCRIPT = """# Reads trials.csv with its types. Written by tactometry export --to r.
trials <- read.csv("trials.csv", na.strings = "NA", stringsAsFactors = FALSE,
                   colClasses = c({classes}))
trials$participant <- factor(trials$participant)
used <- subset(trials, {used})
{factors}
# A probit mixed model of yes/no answers, and the thresholds of an analysis of variance, begin so:
# lme4::glmer(as.integer(response) ~ level {terms} + (1 + level | participant), binomial("probit"), used)
# afex::aov_ez("participant", "threshold", thresholds, within = c({within}))
"""


def r_files(source: Source) -> dict[str, bytes]:
    """`trials.csv` and `trials.R`; the same data give the same bytes."""
    names = [column.name for column in source.columns]
    ordered = [row for _, _, rows in source.sessions() for row in rows]
    body = [[row.get(name) or "NA" for name in names] for row in ordered]
    return {"trials.csv": separated(names, body, ","), "trials.R": _script(source, names).encode()}


def _script(source: Source, names: list[str]) -> str:
    texts = {name for name in names if name in TEXT or (name in source.factors and not _is_number(source, name))}
    kinds = ", ".join(f'"{name}" = "{"character" if name in texts else "numeric"}"' for name in names)
    conditions = ["!is.na(response)"]
    conditions += [f"{name} == {value}" for name, value in (("valid", 1),) if name in names]
    conditions += [f"(is.na({name}) | {name} != 1)" for name in ("practice", "catch") if name in names]
    return SCRIPT.format(
        classes=kinds,
        used=" & ".join(conditions),
        factors="".join(f"used${name} <- factor(used${name})\n" for name in source.factors),
        terms="".join(f"* {name} " for name in source.factors).rstrip(),
        within=", ".join(f'"{name}"' for name in source.factors),
    )


def _is_number(source: Source, name: str) -> bool:
    try:
        return bool([float(text) for row in source.rows if (text := row.get(name))])
    except ValueError:
        return False
