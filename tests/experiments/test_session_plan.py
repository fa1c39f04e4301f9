"""Session plans: conditions, orders, sessions of participants, and their largest levels."""

import itertools
from collections import Counter
from dataclasses import replace
from math import factorial, prod

import numpy as np
import pytest
from examples import examples
from hypothesis import given, strategies as st
from memory import Memory
from own_form import OWN_FORM
from study_texts import TUTORIAL, changed, refusal
from tables import is_sound

from tactometry.errors import InvalidParameter
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.experiments.sessions.simulation import Simulation, simulate
from tactometry.experiments.study.dry_run import duration_s, plan
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.session_plan import session_cells
from tactometry.experiments.study.study_file import load, parse
from tactometry.protocols.order import ORDERS, Crossing, n_orders, nth_permutation
from tactometry.protocols.procedures.practice import Practice
from tactometry.session.request import Show
from tactometry.session.run import run

LEVELS = "levels = [22, 28, 34, 40]                       # dB re 1 V peak\nrepeats = 4"
CONSTANT = f'kind = "constant_stimuli"\n{LEVELS}'
TASK = 'kind = "yes_no"\ncatch_rate = 0.2'


def study(*changes, more=""):
    return parse(changed(TUTORIAL + more, dict(changes)).encode(), "s.toml")


def experiment(*changes, more=""):
    return wire(study(*changes, more=more), "s.toml")


def session_of(made):
    memory = Memory()
    return run(made.course("P01", 1, 1, 1), made.simulated_rig("P01", 1, 1), memory), memory


# --- orders


@given(n=st.integers(1, 6))
def test_complete_counterbalancing_gives_every_order_once(n):
    orders = {tuple(nth_permutation(n, row)) for row in range(factorial(n))}
    assert len(orders) == factorial(n)


@given(n=st.integers(1, 8), row=st.integers(0, 10**6), rule=st.sampled_from(sorted(ORDERS)))
def test_every_rule_gives_each_level_once(n, row, rule):
    assert sorted(ORDERS[rule](n, row, np.random.default_rng(row))) == list(range(n))


sizes = st.lists(st.integers(2, 4), min_size=1, max_size=3)


@given(sizes=sizes)
@examples(25)
def test_williams_orders_balance_predecessors(sizes):
    """Orders are counted within each run of the fastest factor."""
    factors = {f"f{n}": tuple(range(size)) for n, size in enumerate(sizes)}
    crossing = Crossing(factors, dict.fromkeys(factors, "williams"))
    name, levels = list(factors.items())[-1]
    n_rows = prod(n_orders("williams", size) for size in sizes)
    pairs = Counter()
    for row in range(n_rows):
        cells = crossing.cells(row, np.random.default_rng(0))
        for k in range(0, len(cells), len(levels)):
            pairs.update(itertools.pairwise(cell[name] for cell in cells[k : k + len(levels)]))
    assert len(pairs) == len(levels) * (len(levels) - 1)
    assert len(set(pairs.values())) == 1


def test_nested_levels_belong_to_their_outer_level():
    crossing = Crossing(
        {"wave": ("sine", "square"), "hz": (30, 60)}, {"hz": "random"}, {"wave": {"square": {"hz": (1, 2, 3)}}}
    )
    cells = crossing.cells(0, np.random.default_rng(1))
    assert sorted(cell["hz"] for cell in cells if cell["wave"] == "square") == [1, 2, 3]
    assert sorted(cell["hz"] for cell in cells if cell["wave"] == "sine") == [30, 60]


def test_williams_order_of_unequal_design_is_refused():
    with pytest.raises(
        InvalidParameter, match=r"williams order of an unequal design \(2 or 3 levels\), expected equal"
    ):
        Crossing({"w": ("a", "b"), "hz": (1, 2)}, {"hz": "williams"}, {"w": {"b": {"hz": (1, 2, 3)}}})


# --- plans


def test_plan_depends_on_study_number_and_seed():
    drawn = study(more='\n[plan]\norders = { random = ["frequency_hz"] }\n')
    plans = [session_cells(drawn, None, 17, 1, seed) for seed in (3, 3)]
    assert plans[0] == plans[1]
    orders = {tuple(cell["frequency_hz"] for cell in session_cells(drawn, None, 17, 1, seed)) for seed in range(40)}
    assert len(orders) == 2


COUNTERBALANCED = ("trial_s = 5.0", 'trial_s = 5.0\ncounterbalance = ["frequency_hz"]')
TWO_FORCES = (
    ("frequency_hz = [60, 240]", "frequency_hz = [60, 240]\nforce_n = [0.5, 1.0]"),
    ("force_n = 1.0\n", ""),
    COUNTERBALANCED,
)


def test_groups_have_one_level_and_same_orders():
    grouped = study(*TWO_FORCES, more='\n[plan]\nbetween = ["force_n"]\n')
    sessions = [session_cells(grouped, None, n, 1, 0) for n in range(1, 5)]
    assert [{cell["force_n"] for cell in cells} for cells in sessions] == [{0.5}, {1.0}, {0.5}, {1.0}]
    orders = [[cell["frequency_hz"] for cell in cells] for cells in sessions]
    assert orders[0] == orders[1] != orders[2] == orders[3]


def test_sessions_split_the_cells_by_level():
    split = study(COUNTERBALANCED, more='\n[plan]\nsessions = ["frequency_hz"]\n')
    first, second = (session_cells(split, None, 2, n, 0) for n in (1, 2))
    assert [cell["frequency_hz"] for cell in (*first, *second)] == [240, 60]
    with pytest.raises(InvalidParameter, match="--session: found 3, expected from 1 to 2"):
        session_cells(split, None, 2, 3, 0)


def test_simulation_runs_every_planned_session(tmp_path):
    content = f'{TUTORIAL}\n[plan]\nsessions = ["frequency_hz"]\n'.encode()
    recorded = list(simulate(Simulation(content, "s.toml", tmp_path / "d", 2, 1)))
    assert [each.trials.name[:25] for each in recorded] == [
        f"participant-{code}_session-{n}" for code in ("P01", "P02") for n in (1, 2)
    ]
    assert validate(tmp_path / "d").defects == ()


def test_orders_change_with_participant_across_sessions():
    split = study(*TWO_FORCES, more='\n[plan]\nsessions = ["force_n"]\n')
    first = [[cell["frequency_hz"] for cell in session_cells(split, None, number, 1, 0)] for number in (1, 2)]
    assert first == [[60, 240], [240, 60]]


def test_interleaved_factors_share_block_in_tracks():
    made = experiment(more='\n[plan]\ninterleave = ["frequency_hz"]\n')
    (block,) = made.parts(1, np.random.default_rng(1))
    assert [track.name for track in block.tracks] == ["frequency_hz=60", "frequency_hz=240"]
    assert "track" in [column.name for column in made.design(b"").columns]
    _, memory = session_of(made)
    runs = [len(list(group)) for _, group in itertools.groupby(trial.track for trial in memory.trials)]
    assert len(runs) > 4
    named = {(trial.track, trial.factors["frequency_hz"]) for trial in memory.trials}
    assert named == {("frequency_hz=60", 60.0), ("frequency_hz=240", 240.0)}


QUEST_PLUS = """kind = "quest_plus"
low = 0
high = 38
n_levels = 20
width_low = 4
width_high = 16
n_widths = 3
guess_rates = [0.0]
n_trials = 12
shared = true"""


def test_conditions_that_share_a_posterior_run_interleaved():
    made = experiment((CONSTANT, QUEST_PLUS), more='\n[plan]\ninterleave = ["frequency_hz"]\n')
    (planned,) = plan(made, 1)
    assert (planned.n_tracks, planned.n_trials_at_most) == (2, 2 * 15)
    tracks, memory = session_of(made)
    assert {track.ending for track in tracks} <= {"trials", "converged", "censored_above"}
    felt = Counter(trial.track for trial in memory.trials if trial.valid and not trial.catch)
    assert felt == {"frequency_hz=60": 12, "frequency_hz=240": 12}


def test_dry_run_counts_trials_items_and_time():
    made = wire(load("hybrid-button")[0], "hybrid-button")
    blocks = plan(made, 1)
    assert [(block.n_trials_at_most, block.n_items) for block in blocks] == [(4, 12), (4, 12), (4, 12), (0, 6)]
    assert duration_s(made, blocks) == 12 * 8.0 + 42 * 5.0


def test_practice_comes_first_and_is_marked():
    practice = "\n[practice]\nlevels = [40]\nn_correct = 2\nn_of = 2\n"
    _, memory = session_of(experiment(("[60, 240]", "[240]"), more=practice))
    marks = [trial.practice for trial in memory.trials]
    assert marks == sorted(marks, reverse=True)
    assert 2 <= marks.count(True) < 20
    assert {trial.procedure for trial in memory.trials if trial.practice} == {"practice"}
    said = [request.message for request, _ in memory.entries if isinstance(request, Show)]
    assert said[2] == "practice"
    assert set(said) & {"right", "wrong"}


def test_practice_cycles_levels_and_counts_last_answers():
    rule, levels = Practice(levels=(3.0, 2.0, 1.0), n_correct=2, n_of=2, n_trials=9), []
    for answer in (1, 0, 1, 0, 1, 1):
        assert rule.ending is None
        levels.append(rule.level)
        rule = rule.after(answer)
    assert levels == [3.0, 2.0, 1.0, 3.0, 2.0, 1.0]
    assert rule.ending == "converged"
    with pytest.raises(InvalidParameter, match="Practice.after: found a response after the end"):
        rule.after(1)
    missed = Practice(levels=(1.0,), n_correct=3, n_of=3, n_trials=7)
    for n in range(7):
        missed = missed.after(n % 2)
    assert missed.ending == "trials"


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ('[plan]\nsessions = ["force_n"]', "plan.sessions: found 'force_n', expected a factor (frequency_hz)"),
        (
            '[plan]\nbetween = ["frequency_hz"]\nsessions = ["frequency_hz"]',
            "plan.sessions: found 'frequency_hz', which is also in plan.between, expected each factor once",
        ),
        ('[plan]\norders = { latin = ["frequency_hz"] }', "plan.orders: found 'latin', expected one of williams"),
        ('[plan]\norders = { random = ["hz"] }', "plan.orders.random: found 'hz', expected a factor (frequency_hz)"),
        ("[nested.frequency_hz.61]\nfrequency_hz = [1]", "nested.frequency_hz: found '61', expected one of its levels"),
        ("[variants.frequency_hz.60.limit]\n", "variants.frequency_hz.60: found 'limit', expected a table"),
        ('[inquiries.a]\nform = "sos"', "inquiries.a.form: found 'sos', expected one of attrakdiff"),
        ('[inquiries.a]\nform = "sus"\nafter = "never"', "inquiries.a.after: found 'never', expected one of start"),
        (OWN_FORM.replace('form = "mine"', 'form = "mime"'), "form: found 'mime', expected one of mine, attrakdiff, "),
        ("[practice]\nlevels = [34]\nn_correct = 9", "practice.n_correct: found 9, expected from 1 to 5"),
        ("[practice]\nlevels = [90]", "practice: found the highest level 90, expected one within the limits"),
    ],
)
def test_an_impossible_plan_is_refused_in_one_sentence(more, sentence):
    message = refusal(f"{TUTORIAL}\n{more}\n")
    assert sentence in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("task", "sentence"),
    [
        ('kind = "preference"\nover = "force_n"', "task.over: found 'force_n', expected a factor with at least two"),
        ('kind = "rating"\nform = "attrakdif"', "task.form: found 'attrakdif', expected one of attrakdiff"),
        ('kind = "comparison"', "task.standard_level: found no such key, expected a number"),
        ('kind = "adjustment"\nstep = 1\nlow = 20\nhigh = 30', "procedure: found start levels of an adjustment from"),
        ('kind = "comparison"\nstandard_level = 99', "task.standard_level: found the highest level 99, expected one"),
        ('kind = "yes_no"\nn_intervals = 2', "task.n_intervals: found an unknown key, expected one of kind, catch_"),
        ('kind = "yes_no"\nrest_after = 0', "task.rest_after: found 0, expected a whole number, at least 1"),
        ('kind = "yes_no"\nrest_s = 0', "task.rest_s: found 0.0, expected a finite number above 0"),
        ('kind = "rating"\nform = "sus"\ncatch_rate = 0.1', "task.catch_rate: found 0.1 with rating, expected 0"),
    ],
)
def test_an_impossible_task_is_refused_in_one_sentence(task, sentence):
    assert f"s.toml, {sentence}" in refusal(changed(TUTORIAL, {TASK: task}))


# --- every kind from a study file, from session to sound data set

TASKS = {
    "forced_choice": 'kind = "forced_choice"\nn_intervals = 3',
    "same_different": 'kind = "same_different"\nstandard_level = 20\ncatch_rate = 0.5',
    "comparison": 'kind = "comparison"\nstandard_level = 20',
    "magnitude": 'kind = "magnitude"\nhigh = 100',
    "localisation": 'kind = "localisation"\nover = "frequency_hz"',
    "preference": 'kind = "preference"\nover = "frequency_hz"',
    "adjustment": 'kind = "adjustment"\nstep = 2\nlow = 0\nhigh = 40',
    "rating": 'kind = "rating"\nform = "pleasantness-vas"\nshuffled = true',
}
RANGE = "low = 0\nhigh = 38\n"
PROCEDURES = {
    "method_of_limits": f'kind = "method_of_limits"\n{RANGE}step = 4\nn_series = 4\nn_start_steps = 2',
    "quest": f'kind = "quest"\n{RANGE}start = 20\nstart_sd = 10\nstep = 1\nguess_rate = 0.0\nn_trials = 8',
    "psi": f'kind = "psi"\n{RANGE}n_levels = 20\nsd_low = 2\nsd_high = 8\nguess_rate = 0.0\nn_trials = 8',
    "quest_plus": QUEST_PLUS.replace("shared = true", "shared = false"),
    "weighted_staircase": f'kind = "weighted_staircase"\n{RANGE}start = 30\nsteps_up = [3]\nsteps_down = [1]',
}
CHANGES = {name: (TASK, table) for name, table in TASKS.items()} | {
    name: (CONSTANT, table) for name, table in PROCEDURES.items()
}


@pytest.mark.parametrize("kind", CHANGES)
def test_every_task_and_procedure_runs_from_a_study_file(tmp_path, kind):
    content = changed(TUTORIAL, dict([CHANGES[kind]])).encode()
    made, who = wire(parse(content, "s.toml"), "s.toml"), Who("P01", seed=4)
    session = record(made, content, tmp_path / "d", who, simulated(made, who))
    assert session.n_trials >= 8
    assert all(track.ending for track in session.tracks)
    assert is_sound(tmp_path / "d")


def test_shared_parts_of_cells_are_built_once():
    made = experiment((CONSTANT, QUEST_PLUS))
    assert len(made.cells) == 2
    assert len({id(cell.procedure.rule) for cell in made.cells.values()}) == 1
    asked = wire(load("hybrid-button")[0], "s.toml")
    forms = [part.form for _ in range(2) for part in asked.parts(1, np.random.default_rng(0)) if hasattr(part, "form")]
    assert forms
    assert all(any(form is known for known in asked.questionnaires) for form in forms)


def test_strongest_level_includes_practice():
    softer = LEVELS, LEVELS.replace("34, 40", "34")
    plain, practised = experiment(softer), experiment(softer, more="\n[practice]\nlevels = [40]\n")
    assert {(each.where, each.level) for each in plain.strongest()} == {("procedure", 34.0)}
    assert {(each.where, each.level) for each in practised.strongest()} == {("practice", 40.0)}
    assert [each.name for each in practised.strongest()] == list(practised.bank)
    first = practised.strongest()[0]
    assert np.array_equal(first.signal.samples, first.stimulus.at(40.0).samples)


# --- largest levels over all cells


def together(first, second):
    """Return a study whose stimulus has two cells with different levels."""
    key, cell = next(iter(experiment().cells.items()))
    other = {tuple((name, f"{level} again") for name, level in key): replace(cell, procedure=second)}
    return replace(experiment(), cells={key: replace(cell, procedure=first)} | other)


def test_scenes_of_some_stimuli_are_named():
    study = experiment()
    (key, cell), *others = study.cells.items()
    words = study.felt
    assert words
    assert cell.condition.stimulus not in words
    of_one = replace(study, cells={key: cell} | {key: replace(cell, sensation=object()) for key, cell in others})
    assert of_one.felt == f"{cell.condition.stimulus}: {words}"


@pytest.fixture(scope="module")
def procedures():
    studies = experiment(), experiment((LEVELS, LEVELS.replace("22, 28, 34, 40", "10, 20")))
    return [next(iter(study.cells.values())).procedure for study in studies]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_strongest_level_is_taken_over_all_cells(procedures, order):
    study = together(*(procedures[n] for n in order))
    (strongest,) = study.strongest()
    assert strongest.level == 40.0
    assert study.bounds(strongest.name) == (10.0, 40.0)


@pytest.mark.parametrize(
    ("task", "n_tracks"),
    [(TASK, 2), ('kind = "localisation"\nover = "frequency_hz"', 1), ('kind = "preference"\nover = "frequency_hz"', 1)],
)
def test_alternatives_that_share_a_track_are_counted_once(task, n_tracks):
    """A million trials are allowed: two tracks of two cells, or one shared."""
    repeats = 1_000_000 // 4 // n_tracks
    assert experiment((TASK, task), ("repeats = 4", f"repeats = {repeats}")).cells
    with pytest.raises(InvalidParameter, match="trials of all cells: found|repeats: found"):
        experiment((TASK, task), ("repeats = 4", f"repeats = {repeats + 1}"))


@pytest.mark.parametrize(("task", "has"), [(TASK, False), ('kind = "preference"\nover = "frequency_hz"', True)])
def test_study_with_several_tracks_has_track_column(task, has):
    columns = experiment((TASK, task)).design(b"").columns
    assert ("track" in {column.name for column in columns}) == has


def test_equal_cells_share_one_feeling():
    """A force tolerance does not change the sensation."""
    more = '\n[observer.people.effects_db.tolerance]\n"{}" = 1.0\n'
    of_two = [("frequency_hz = [60, 240]", "frequency_hz = [60, 240]\ntolerance = [0.1, 0.3]"), ("tolerance = 0.2", "")]
    plain, first, second = (experiment(*of_two, more=also) for also in ("", more.format(0.1), more.format(0.3)))
    assert (len(plain.cells), len(plain.feelings("P01", 1))) == (4, 2)
    assert plain.feelings("P01", 1) == second.feelings("P01", 1) != first.feelings("P01", 1)
    assert {cell.condition.factors["tolerance"] for cell in plain._met.values()} == {0.1}
