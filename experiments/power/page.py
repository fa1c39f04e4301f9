"""The page of a power analysis: the recommendation, what was applied to whom, table, figure, and how to repeat it."""

import json
from importlib.resources import files
from pathlib import Path

from tactometry.errors import attempt
from tactometry.provenance import versions

from .analysis import Power
from .design import PowerDesign
from .figures import power_curves
from .files import asked
from .scenario import experiment_of
from .summary import HEAD, cells_of

PAGE, FIGURE = "power.html", "power"


def write_page(found: Power, root: Path) -> None:
    """The page, which needs no network, and its figure as SVG and PNG.

    Raises
    ------
    DeviceFailed
        If a file cannot be written.
    """
    drawing = power_curves(found.design, found.points)
    with attempt(root, "cannot write", "a place to write to"):
        (root / f"{FIGURE}.svg").write_text(drawing.svg, encoding="utf-8")
        (root / f"{FIGURE}.png").write_bytes(drawing.png())
        (root / PAGE).write_text(page(found, drawing.svg), encoding="utf-8")


def page(found: Power, svg: str) -> str:
    """The text of the page; the same results give the same text."""
    from jinja2 import Environment, StrictUndefined

    design, effect = found.design, found.design.effect
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string((files(__package__) / PAGE.replace(FIGURE, "page")).read_text("utf-8")).render(
        study=design.where,
        effect=effect.words(),
        factor=effect.factor,
        unit=effect.unit,
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


def applied(design: PowerDesign) -> list[tuple[str, ...]]:
    """Of each level of the factor what is stated, and what everybody feels more with the effect and without it."""
    effect, (yes, no) = design.effect, design.cases[:2]
    studies = [experiment_of(design, case).study for case in (yes, no)]
    with_db, without_db = (study.observer["people"]["effects_db"][effect.factor] for study in studies)
    stated = effect.of_levels(studies[0].factors[effect.factor])
    return [(name, *(f"{value:.2f}" for value in (stated[name], with_db[name], without_db[name]))) for name in stated]
