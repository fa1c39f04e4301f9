"""`tactometry scene`."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from tactometry.experiments.scenes import path_of
from tactometry.stimuli.scenes import explain as plans
from tactometry.stimuli.scenes.file import SceneFile, load_scene
from tactometry.stimuli.scenes.plan import Plan, PulledFinger, Result, compute, predicted_s, pulled_fingers

from ..arguments.require import expect
from ..config.toml import errors_in
from .output import SCENE, figure_option, path_option, say, subcommand, writing

FILM_ACCURACY = 0.1
LONG_S = 5.0
"""Predicted time above which it is printed before the computation."""


@subcommand("scene electrovibration-panel --explain")
@click.argument("file", metavar="FILE", type=SCENE)
@click.option("--explain", is_flag=True, help="Print which stages run and why, with settings, error and time.")
@figure_option("Draw the outputs as PNG, PDF or SVG.")
@path_option("--movie", help="Write a movie of the focusing wave as GIF or MP4.")
@click.option("--cache", type=click.Path(path_type=Path, file_okay=False), help="Folder in which results are cached.")
def command(*, file: str, explain: bool, figure: Path | None, movie: Path | None, cache: Path | None) -> None:
    """Compute a scene: a TOML file, or the name of a built-in one.

    Only the stated effects are computed, at the stated accuracy.
    """
    scene_file = load_scene(path_of(file))
    if explain:
        with errors_in(file):
            text = plans.explanation(scene_file.scene, scene_file.given)
        say(text, {"plan": text.splitlines()})
    if figure is not None or not explain:
        with errors_in(file):
            plan = scene_file.scene.resolve()
            given = plans.values_for(plan, scene_file.given)
        # printed before the work begins, on standard error
        if plan.predicted_s > LONG_S:
            longest = max(plan.stages, key=predicted_s)
            click.echo(
                f"this takes about {plan.predicted_s:.0f} s, mostly for {longest.name!r}; a lower accuracy is faster",
                err=True,
            )
        result = _result(file, plan, given, cache)
    if figure is not None:
        with writing(figure):
            _figure(result, scene_file.title).savefig(figure, dpi=150)
    if movie is not None:
        _film(scene_file, movie)
    if not explain:
        pulled = pulled_fingers(result) or plans.pulled_by(scene_file.scene, plan, given)
        record = _record(result, pulled) | {"rests_on": scene_file.scene.rests_on()}
        say(_text(scene_file, record, result, pulled), record)


def _result(file: str, plan: Plan, given: dict[str, float], cache: Path | None) -> Result:
    if cache is None:
        with errors_in(file):
            return compute(plan, given)
    from tactometry.stimuli.scenes.cache import cached_result

    with writing(cache), errors_in(file):
        return cached_result(plan, given, cache)


def _figure(result: Result, title: str) -> Any:
    """Draw a map with time courses, or only time courses."""
    if {"x_m", "y_m", "field_m"} <= set(result.values):
        from tactometry.stimuli.scenes.figures.courses import focus_sheet

        return focus_sheet(result, title)
    neither = "neither 't_s' nor 'x_m', 'y_m' and 'field_m' among the outputs of the scene"
    expect("t_s" in result.values, "--figure", neither, "'t_s', or 'x_m', 'y_m' and 'field_m'; add them to outputs")
    from tactometry.stimuli.scenes.figures.courses import courses, names

    some = "at least one course, such as 'friction_force_n' or 'focus_displacement_m'; add it to outputs"
    expect(bool(names(result.values)), "--figure", "no course over 't_s' in the outputs of the scene", some)
    return courses(result, title)


def _film(scene_file: SceneFile, path: Path) -> None:
    """Create a movie of the scene, no finer than its resolution."""
    from tactometry.stimuli.scenes.effects.movie import Movie
    from tactometry.stimuli.scenes.figures.courses import write_film

    scene = scene_file.scene
    still = f"a scene on {scene.surface.kind!r}, which has no wave"
    expect(Movie.kind in scene.surface.effects, "--movie", still, "a plate: 'time_reversal' or 'hybrid'")
    effects = scene.effects if scene.find("movie") else (*scene.effects, Movie())
    outputs = ("x_m", "y_m", "frames_s", "movie_m")
    filmed = replace(scene, effects=effects, outputs=outputs, accuracy=max(scene.accuracy, FILM_ACCURACY), settings={})
    plan = filmed.resolve()
    result = compute(plan, plans.values_for(plan, scene_file.given))
    with writing(path):
        write_film(result, scene_file.title, path)


def _record(result: Result, pulled: list[PulledFinger]) -> dict[str, Any]:
    def summary(value: Any) -> Any:
        if np.ndim(value) == 0:
            return float(value)
        course = np.asarray(value)
        return {"n": int(course.size), "min": float(course.min()), "max": float(course.max())} if course.size else []

    outputs = {name: summary(value) for name, value in result.values.items()}
    return {
        "outputs": outputs,
        "units": {name: result.unit(name) for name in outputs},
        "given": dict(result.given),
        "pulls_n": [max(finger.pull_n - finger.force_n, 0.0) for finger in pulled],
        "contact": [asdict(finger) for finger in pulled],
        "predicted_error": result.plan.error,
        "elapsed_s": result.elapsed_s,
        "prepared_s": result.prepared_s,
        "versions": dict(result.versions),
        "seed": None,
        "plan": [
            {"stage": stage.name, "gives": stage.gives, "target": stage.target, "settings": dict(stage.settings)}
            for stage in result.plan.stages
        ],
    }


def _text(scene_file: SceneFile, record: dict[str, Any], result: Result, pulled: list[PulledFinger]) -> str:
    lines = [scene_file.title] if scene_file.title else []
    for name, value in record["outputs"].items():
        unit = result.unit(name)
        words = f"{value:.6g}" if isinstance(value, float) else _range(value)
        lines.append(f"{name:<24}{words} {unit}".rstrip())
    error = plans.error_in_words(result.plan)
    times = f"{result.prepared_s:.3g} s to prepare, {result.elapsed_s:.2g} s a run"
    opened = scene_file.scene.find("lift_off") is not None
    cure = "" if opened else "; the effect 'lift_off' follows it"
    lifted = [f"{finger.line}{cure}" for finger in pulled if finger.lifts_off]
    rests_on = list(filter(None, [plans.rests_on_in_words(scene_file.scene)]))
    return "\n".join([*lines, *rests_on, *lifted, f"predicted error {error}, {times}"])


def _range(value: Any) -> str:
    return f"{value['min']:.4g} .. {value['max']:.4g} ({value['n']} values)" if value else "none"
