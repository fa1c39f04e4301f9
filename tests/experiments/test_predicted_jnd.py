"""Predicted sensation levels, and the just noticeable differences that a dry run states."""

import json

import numpy as np
import pytest
from command_line import output
from scipy.special import ndtri
from study_texts import changed, wired

from tactometry.contact import Contact
from tactometry.experiments.study.predictions import N_LEVELS, contact_of, felt_db, level_table, predicted_jnds
from tactometry.experiments.study.study_file import load
from tactometry.protocols.batch.tracks import tracks

TEXTURE = load("texture-discrimination")[1].decode()
STATED = {"[observer]": '[observer]\nkind = "psychometric"\nthreshold = 20.0\nwidth = 6.0\n'}
HALVED = {"[observer]": STATED["[observer]"] + "conditions = [{ period_m = 0.001, width = 3.0 }]\n"}


def test_dry_run_prints_predicted_jnds(capsys):
    dry_run = ["run", "texture-discrimination", "--participant", "P01", "--rig", "simulated", "--dry-run"]
    text = output(capsys, *dry_run)
    found = json.loads(output(capsys, *dry_run, "--json"))["jnd"]
    assert [row["condition"] for row in found] == ["period_m 0.0005", "period_m 0.001"]
    assert f"predicted JND at the standard of 40 dB re 1 V: {found[0]['jnd']:.2f} dB at period_m 0.0005" in text


def test_observer_calls_the_predicted_level_stronger_in_three_quarters():
    experiment = wired(TEXTURE)
    observer, rng, n = experiment.people.middle, np.random.default_rng(1), 20000
    for cell, predicted in zip(experiment.cells.values(), predicted_jnds(experiment), strict=True):
        felt = [felt_db(cell, level, contact_of(cell)) for level in (40.0, 40.0 + predicted.jnd)]
        share = np.mean([observer.compare(felt, rng) for _ in range(n)])
        expected = observer.lapse_rate / 2 + (1 - observer.lapse_rate) * 0.75
        assert share == pytest.approx(expected, abs=4.5 * np.sqrt(0.19 / n))


def test_stated_widths_give_the_jnd():
    first, second = predicted_jnds(wired(changed(TEXTURE, HALVED)))
    assert first.jnd == pytest.approx(ndtri(0.75) * 6.0 / (2 * ndtri(0.95)))
    assert second.jnd == pytest.approx(first.jnd / 2)
    assert "constant touch" not in first.line


@pytest.mark.parametrize("levels", ["[39, 39.5, 40]", "[39, 40, 40.1]"])
def test_jnd_beyond_the_levels_is_named(levels):
    narrow = changed(TEXTURE, {"levels = [31, 34, 37, 39, 41, 43, 46]": f"levels = {levels}"})
    assert all("above the highest level" in one.line for one in predicted_jnds(wired(narrow)))


def test_other_tasks_have_no_jnd():
    assert not list(predicted_jnds(wired(load("tutorial")[1].decode())))


# --- tables of sensation levels through the scene of a study


@pytest.fixture(scope="module")
def cells():
    return tuple(wired(load("electrovibration-threshold")[1].decode()).cells.values())


def test_level_table_equals_scene_at_levels(cells):
    cell, levels = cells[0], (10.0, 20.0, 35.0)
    table = level_table(cell, levels, Contact(0.5, 0.05))
    assert table.felt[0].tolist() == [felt_db(cell, level, Contact(0.5, 0.05)) for level in levels]
    assert (np.diff(table.felt[0]) > 0).all()


def test_level_table_interpolates_scene(cells):
    cell = cells[0]
    table, (low, high) = level_table(cell), cell.procedure.rule.bounds
    assert len(table.levels) in (N_LEVELS, len(getattr(cell.procedure.rule, "levels", ())))
    for level in np.linspace(low + 0.3 * (high - low), high, 7):
        interpolated_db = np.interp(level, table.levels, table.felt[0])
        felt_at_level_db = level_table(cell, (level, level + 1.0)).felt[0, 0]
        assert interpolated_db == pytest.approx(felt_at_level_db, abs=0.1)


def test_batch_finds_the_level_at_threshold(cells):
    """The observer feels exactly the levels above 0 dB."""
    cell = cells[0]
    table = level_table(cell)
    made = tracks(cell.procedure.rule, np.zeros((1, 100)), table)
    at_zero = np.interp(0.0, table.felt[0], table.levels)
    last = made.levels[0, : made.n_trials[0]][-8:]
    assert last.min() - 1.0 <= at_zero <= last.max() + 1.0
