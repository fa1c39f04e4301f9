"""Largest levels and forces of a wired study, checked against limits."""

from dataclasses import replace

import pytest
from study_texts import TUTORIAL, changed

from tactometry.errors import InvalidParameter
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse

LEVELS = "levels = [22, 28, 34, 40]                       # dB re 1 V peak\nrepeats = 4"
TASK = 'kind = "yes_no"\ncatch_rate = 0.2'


def wired(changes=(), more=""):
    return wire(parse(changed(TUTORIAL + more, dict(changes)).encode(), "s.toml"), "s.toml")


def together(first, second):
    """Return a study whose stimulus has two cells with different levels."""
    key, cell = next(iter(wired().cells.items()))
    other = {tuple((name, f"{level} again") for name, level in key): replace(cell, procedure=second)}
    return replace(wired(), cells={key: replace(cell, procedure=first)} | other)


def test_scenes_of_some_stimuli_are_named():
    study = wired()
    (key, cell), *others = study.cells.items()
    words = study.felt
    assert words
    assert cell.condition.stimulus not in words
    of_one = replace(study, cells={key: cell} | {key: replace(cell, sensation=object()) for key, cell in others})
    assert of_one.felt == f"{cell.condition.stimulus}: {words}"


@pytest.fixture(scope="module")
def procedures():
    studies = wired(), wired([(LEVELS, LEVELS.replace("22, 28, 34, 40", "10, 20"))])
    return [next(iter(study.cells.values())).procedure for study in studies]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_strongest_level_is_taken_over_all_cells(procedures, order):
    study = together(*(procedures[n] for n in order))
    (strongest,) = study.strongest()
    assert strongest.level == 40.0
    assert study.bounds(strongest.name) == (10.0, 40.0)


def test_bounds_are_taken_over_all_cells():
    study = wired([(LEVELS, LEVELS.replace("34, 40", "34"))], "\n[practice]\nlevels = [4, 40]\n")
    assert {(each.where, each.level) for each in study.strongest()} == {("practice", 40.0)}


@pytest.mark.parametrize(
    ("task", "n_tracks"),
    [(TASK, 2), ('kind = "localisation"\nover = "frequency_hz"', 1), ('kind = "preference"\nover = "frequency_hz"', 1)],
)
def test_alternatives_that_share_a_track_are_counted_once(task, n_tracks):
    """A million trials are allowed: two tracks of two cells, or one shared."""
    repeats = 1_000_000 // 4 // n_tracks
    assert wired([(TASK, task), ("repeats = 4", f"repeats = {repeats}")]).cells
    with pytest.raises(InvalidParameter, match="trials of all cells: found|repeats: found"):
        wired([(TASK, task), ("repeats = 4", f"repeats = {repeats + 1}")])


@pytest.mark.parametrize(("task", "has"), [(TASK, False), ('kind = "preference"\nover = "frequency_hz"', True)])
def test_study_with_several_tracks_has_track_column(task, has):
    columns = wired([(TASK, task)]).design(b"").columns
    assert ("track" in {column.name for column in columns}) == has


def test_equal_cells_share_one_feeling():
    """A force tolerance does not change the sensation."""
    more = '\n[observer.people.effects_db.tolerance]\n"{}" = 1.0\n'
    of_two = [("frequency_hz = [60, 240]", "frequency_hz = [60, 240]\ntolerance = [0.1, 0.3]"), ("tolerance = 0.2", "")]
    plain, first, second = (wired(of_two, also) for also in ("", more.format(0.1), more.format(0.3)))
    assert (len(plain.cells), len(plain.feelings("P01", 1))) == (4, 2)
    assert plain.feelings("P01", 1) == second.feelings("P01", 1) != first.feelings("P01", 1)
    assert {cell.condition.factors["tolerance"] for cell in plain._met.values()} == {0.1}
