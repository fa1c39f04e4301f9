"""Run a power analysis, and write its page and recommendation."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

from tactometry.errors import attempt
from tactometry.provenance import versions

from ..workers import Spread, here
from .design import PowerDesign
from .files import Batch, Folder, asked, sample
from .scenario import experiment_of, felt_more, maps_of
from .scores import applied_effect, attitudes_of
from .summary import HEAD, PowerEstimate, Summary, cautions, cells_of, recommendation


@dataclass(frozen=True)
class Power:
    """Results of a power analysis."""

    design: PowerDesign
    points: tuple[PowerEstimate, ...]
    recommendation: str
    cautions: tuple[str, ...]


def power(
    design: PowerDesign,
    spread: Spread = here,
    folder: Folder | None = None,
    tell: Callable[[Batch], None] = lambda batch: None,
) -> Power:
    """Simulate studies until their powers are precise enough.

    Batches stored in `folder` are reused.
    """
    result = Summary(design)
    stored = () if folder is None else (folder.kept, folder.keep, folder.simulated)
    batches = sample(design, spread, *stored)
    for batch, rows in batches:
        result.add(rows)
        tell(batch)
    points = result.points()
    if folder is not None:
        folder.write_table(points)
    return Power(design, points, recommendation(design, points), tuple(cautions(design, points)))


PAGE, FIGURE = "power.html", "power"


def write_page(found: Power, root: Path) -> None:
    """Write the offline HTML page, and its figure as SVG and PNG.

    Raises `DeviceFailed` if a file cannot be written.
    """
    from .figures import power_curves

    drawing = power_curves(found.design, found.points)
    with attempt(root, "cannot write", "a place to write to"):
        (root / f"{FIGURE}.svg").write_text(drawing.svg, encoding="utf-8")
        (root / f"{FIGURE}.png").write_bytes(drawing.png())
        (root / PAGE).write_text(page(found, drawing.svg), encoding="utf-8")


def page(found: Power, svg: str) -> str:
    """Return the page as HTML. The same results give the same text."""
    from jinja2 import Environment, StrictUndefined

    design, effect = found.design, found.design.effect
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string((files(__package__) / PAGE.replace(FIGURE, "page")).read_text("utf-8")).render(
        study=design.where,
        effect=effect.words(),
        seed=design.seed,
        dependent=design.dependent,
        dropout_share=design.dropout_share,
        recommendation=found.recommendation,
        cautions=found.cautions,
        svg=svg,
        head=HEAD,
        rows=[cells_of(point) for point in found.points],
        applied=applied(design),
        asked=json.dumps({**asked(design), "versions": versions()}, indent=2),
    )


@dataclass(frozen=True)
class Applied:
    """Simulated change at each level of a factor: text and table rows."""

    words: str
    head: tuple[str, ...]
    rows: list[tuple[str, ...]]


def applied(design: PowerDesign) -> Applied:
    """Describe the stated and the simulated change at each level."""
    studies = [experiment_of(design, case).study for case in design.cases[:2]]
    effect = applied_effect(design.effect, studies[0])
    stated = effect.of_levels(studies[0].factors[effect.factor])
    if effect.is_of_score:
        made, columns = [attitudes_of(study, effect.factor) for study in studies], ATTITUDES
    elif effect.moves_levels:
        maps = maps_of(design, design.cases[0])
        made = [{level: getattr(one, part) for level, one in maps.items()} for part in ("shift", "factor")]
        columns = MOVED
    else:
        made, columns = [felt_more(study, effect.factor) for study in studies], FELT
    rows = [(name, *(f"{value:.2f}" for value in (stated[name], *(of[name] for of in made)))) for name in stated]
    of_levels = WORDS_OF_MOVED if effect.moves_levels else WORDS_OF_LEVELS
    words = (WORDS_OF_SCORES if effect.is_of_score else of_levels).format(factor=effect.factor)
    return Applied(words, (effect.factor, f"stated ({effect.unit})", *columns), rows)


FELT: Final = ("felt more with the effect (dB)", "without (dB)")
ATTITUDES: Final = ("attitude with the effect (-1 to 1)", "without")
MOVED: Final = ("levels moved up by", "and stretched by")
WORDS_OF_MOVED: Final = (
    "All levels of {factor} are felt alike at the standard (magnitudes: in the middle of the levels). The effect moves "
    "and stretches the scale of the levels about that point: a stretch of 1.2 makes a just noticeable difference 1.2 "
    "times as large and divides an exponent by 1.2. Other differences between participants are those of [observer] and "
    "[observer.people] in the study."
)
WORDS_OF_LEVELS: Final = (
    "At each level of {factor}, every participant feels this many decibels more than the skin model predicts. Without "
    "the effect, all levels of {factor} are felt alike in the middle of the played levels, averaged over other "
    "factors. With the effect, they differ as stated. Other differences are those of [observer] and [observer.people] "
    "in the study."
)
WORDS_OF_SCORES: Final = (
    "Every participant has these attitudes to the levels of {factor}, all of which are felt alike. Without the effect "
    "no dimension of the questionnaire differs between them. Other differences between participants are those "
    "of [observer.people] and [observer.raters] in the study."
)
