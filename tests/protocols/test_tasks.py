"""Tasks: requests, rows, procedure updates and simulated answers."""

import math
from collections import Counter
from dataclasses import replace

import catalogue
import numpy as np
import pytest
from hypothesis import given, strategies as st
from memory import Memory

from tactometry.analysis.tasks.signal_detection import interval_bias
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.task_table import DECISIONS, TASKS
from tactometry.protocols import (
    AdjustmentTask,
    Block,
    Comparison,
    Condition,
    ConstantStimuli,
    ForcedChoice,
    Localisation,
    Magnitude,
    Rating,
    Track,
)
from tactometry.protocols.block import run_block
from tactometry.protocols.tasks.rating import fill_in, pages
from tactometry.protocols.tasks.task import Alternative, Presentation, TrialOutcome
from tactometry.questionnaire import load
from tactometry.rigs.texts import languages, texts_in
from tactometry.session.answer import Chosen, Filled, Rated
from tactometry.session.request import Adjust, Choose, Enter, Fill, Press, Record, Slide
from tactometry.session.run import run
from tactometry.trials.columns import OPTIONAL
from tactometry.trials.tasks import TASKS as ROWS_OF_TASKS

AT_1E_4 = 3.89
FULL = load("attrakdiff")


def lived(task, procedure="constant_stimuli_shuffled", seed=1, observer="default", **how):
    memory = Memory()
    block = catalogue.block(task, procedure)
    block = replace(block, options=replace(block.options, **how))
    run(run_block(block, 1, 1, np.random.default_rng(seed)), catalogue.simulated(seed, observer), memory)
    return memory


def answered(task, shown, rng, answers):
    """Return a trial's outcome for these answers and steady touches."""
    rig, course = catalogue.simulated(), task.trial(shown, rng)
    request = next(course)
    try:
        while True:
            answer = rig.answer(request) if isinstance(request, Press | Slide) else answers(request)
            request = course.send(answer)
    except StopIteration as stop:
        return stop.value


def shown(level, **more):
    return Presentation("tone", level, catalogue.TOUCHES["press"], **more)


def choosing(option):
    """Return an answerer that picks the option by `option`."""
    return lambda request: Chosen(option(request), 0.0, 1.0)


def touches_of_trials(memory):
    """Yield each trial with the touches before its row."""
    touches = []
    for request, _ in memory.entries:
        if isinstance(request, Slide):
            touches.append(request)
        if isinstance(request, Record):
            yield request.trial, touches
            touches = []


@pytest.mark.parametrize("task", ["same_different", "comparison"])
def test_pair_contains_standard_and_level_at_target(task):
    orders = Counter()
    for trial, touches in touches_of_trials(lived(task, catch_rate=0.25)):
        if trial.valid:
            pair = [touch.level for touch in touches]
            compared = 20.0 if trial.level is None else trial.level
            assert pair[trial.target - 1] == compared
            assert pair[2 - trial.target] == trial.standard_level == 20.0
            assert [touch.interval for touch in touches] == [1, 2]
            orders[trial.target] += 1
    assert set(orders) == {1, 2}


@given(seed=st.integers(0, 2**32 - 1), level=st.sampled_from([10.0, 20.0, 30.0]), option=st.sampled_from([1, 2]))
def test_comparison_is_scored_by_choice_of_stronger(seed, level, option):
    outcome = answered(Comparison(20.0), shown(level), np.random.default_rng(seed), choosing(lambda request: option))
    (reply,) = outcome.replies
    stronger = option == outcome.target
    assert reply.response == int(stronger) == int(outcome.success)
    assert reply.correct == (None if level == 20.0 else stronger == (level > 20.0))


@pytest.mark.parametrize("n_intervals", [1, 5])
def test_fewer_or_more_intervals_are_refused(n_intervals):
    with pytest.raises(InvalidParameter, match=f"n_intervals: found {n_intervals}, expected"):
        ForcedChoice(n_intervals)


def test_equal_pair_is_catch_trial_without_level():
    memory = lived("same_different", catch_rate=0.5)
    same = [trial for trial in memory.trials if trial.catch]
    assert same
    assert all(trial.level is None and trial.level_delivered is None for trial in same)
    scored = [trial for trial in memory.trials if trial.valid]
    assert all(trial.correct == (trial.response == (not trial.catch)) for trial in scored)
    questions = {request for request, _ in memory.entries if isinstance(request, Choose)}
    assert questions == {Choose("same_different", (0, 1), ("same", "different"))}


def test_magnitude_rises_with_level():
    memory = lived("magnitude", observer="keen")
    weak, strong = (
        np.mean([trial.response for trial in memory.trials if trial.level == level and trial.valid])
        for level in (10.0, 30.0)
    )
    assert weak < strong
    assert {request for request, _ in memory.entries if isinstance(request, Enter)} == {Enter("how_strong", 0.0)}


@pytest.mark.parametrize(("said", "felt"), [(0.0, False), (0.5, True), (None, False)])
def test_magnitude_zero_or_missing_counts_as_not_felt(said, felt):
    outcome = answered(Magnitude(), shown(20.0), np.random.default_rng(1), lambda _: Rated(said, 0.0, 1.0))
    assert (outcome.success, outcome.replies[0].response) == (felt, said)


PLACES = tuple(Alternative(f"focus {n}", str(n), {"x": float(n)}) for n in (1, 2, 3))


@given(seed=st.integers(0, 2**32 - 1))
def test_localisation_row_contains_factors_of_drawn_place(seed):
    first = choosing(lambda request: request.options[0])
    outcome = answered(Localisation(), shown(20.0, alternatives=PLACES), np.random.default_rng(seed), first)
    assert outcome.factors == {"x": float(outcome.target)}
    assert outcome.success == (outcome.target == 1)


def test_strong_focus_is_located_and_weak_guessed():
    condition = Condition({}, "tone", "dB re 1 V", catalogue.TOUCHES["press"], alternatives=PLACES)

    def correct(level):
        block, memory = Block((Track(condition, ConstantStimuli((level,), 300)),), Localisation()), Memory()
        run(run_block(block, 1, 1, np.random.default_rng()), catalogue.simulated(observer="keen"), memory)
        return [trial.correct for trial in memory.trials if trial.valid]

    strong, weak = correct(40.0), correct(-60.0)
    assert all(strong)
    assert abs(np.mean(weak) - 1 / 3) <= AT_1E_4 * math.sqrt(2 / 9 / len(weak))
    assert len(strong) >= 300


def test_preference_row_names_items_in_presented_order():
    memory = lived("preference")
    orders = Counter((trial.item, trial.item_b) for trial in memory.trials if trial.valid)
    assert set(orders) == {("1", "2"), ("2", "1")}
    assert {trial.response for trial in memory.trials if trial.valid} <= {1, 2}
    for trial, touches in touches_of_trials(memory):
        if trial.valid:
            assert [touch.stimulus for touch in touches] == [f"place {trial.item}", f"place {trial.item_b}"]


def test_adjustment_starts_at_level_and_ends_near_threshold():
    memory = lived("adjustment")
    asked = [request for request, _ in memory.entries if isinstance(request, Adjust)]
    assert [request.start for request in asked] == [trial.level for trial in memory.trials]
    assert {(request.target_n, request.speed_m_per_s) for request in asked} == {(1.0, 0.05)}
    settings = [trial.response for trial in memory.trials]
    assert all(0.0 <= level <= 40.0 for level in settings)
    assert abs(np.mean(settings) - 20.0) < 10.0
    assert {trial.force_mean_n for trial in memory.trials} == {None}


@pytest.mark.parametrize(
    ("numbers", "words"), [((2.0, 9.0, 3.0), "less than high"), ((20.0, 0.0, 10.0), "at most the range")]
)
def test_invalid_adjustment_is_refused(numbers, words):
    with pytest.raises(InvalidParameter, match=words):
        AdjustmentTask(*numbers)


def test_rating_records_a_row_for_each_item():
    memory = lived("rating")
    trial = [row for row in memory.trials if row.trial == 1 and row.valid]
    assert sorted(row.item for row in trial) == sorted(item.id for item in load("attrakdiff-haptic").items)
    assert {row.procedure for row in trial} == {"attrakdiff-haptic"}
    assert {row.task for row in trial} == {"rating"}
    assert {row.response for row in trial} <= set(range(1, 8))


def test_items_are_in_published_or_random_order():
    def orders(*, shuffled):
        block = catalogue.block("rating", "constant_stimuli")
        memory = Memory()
        task = Rating(load("attrakdiff-mini"), shuffled=shuffled)
        run(run_block(replace(block, task=task), 1, 1, np.random.default_rng(1)), catalogue.simulated(), memory)
        asked = [request for request, _ in memory.entries if isinstance(request, Fill)]
        pairs = zip(asked[::2], asked[1::2], strict=True)
        return {tuple(q.item for page in pair for q in page.questions) for pair in pairs}

    published = tuple(item.id for item in load("attrakdiff-mini").items)
    assert orders(shuffled=False) == {published}
    drawn = orders(shuffled=True)
    assert len(drawn) > 5
    assert {tuple(sorted(order)) for order in drawn} == {tuple(sorted(published))}


@pytest.mark.parametrize(
    ("name", "sizes", "most"), [("attrakdiff", [7] * 4, 7), ("attrakdiff-mini", [5, 5], 7), ("sus", [5, 5], 5)]
)
def test_questionnaire_pages_are_equally_long_up_to_maximum(name, sizes, most):
    form = load(name)
    assert [len(page.questions) for page in pages(form, form.items)] == sizes
    assert [len(pages(form, form.items[:n])) for n in (most, most + 1)] == [1, 2]


def test_unanswered_item_has_empty_response():
    course = fill_in(load("attrakdiff-haptic"), np.random.default_rng(1), shuffled=False)
    page = next(course)
    values = (None, *(float(n) for n in range(1, len(page.questions))))
    with pytest.raises(StopIteration) as stop:
        course.send(Filled(values, 0.0, 9.0))
    replies = stop.value.value
    assert [reply.response for reply in replies] == list(values)
    assert TrialOutcome((), replies=replies).valid


def test_scores_of_constant_raw_answers_follow_item_reversals():
    course = fill_in(FULL, np.random.default_rng(1), shuffled=True)
    page, replies = next(course), None
    try:
        while True:
            page = course.send(Filled((7.0,) * len(page.questions), 0.0, 1.0))
    except StopIteration as stop:
        replies = stop.value
    scores = FULL.scores({reply.item: reply.response for reply in replies})
    rounded = {name: round(7 * score, 9) for name, score in scores.items()}
    assert rounded == {"PQ": -3, "HQI": 3, "HQS": -3, "ATT": -3, "HQ": 0}


def test_simulated_participant_answers_every_question():
    requests = [request for task in catalogue.TASKS for request, _ in lived(task).entries]
    assert {request.question for request in requests if isinstance(request, Choose)} == set(DECISIONS)


@pytest.mark.parametrize("language", languages())
def test_tasks_and_questions_have_texts_in_every_language(language):
    asked = {question for kind in TASKS.values() for question in kind.questions}
    instructions = {f"instructions_{name}" for name in TASKS}
    assert asked | instructions <= set(texts_in(language, {}).messages)


@pytest.mark.parametrize("name", TASKS)
def test_task_has_registered_name_and_existing_columns(name):
    assert catalogue.REGISTERED[name].name == name
    assert set(ROWS_OF_TASKS[name].columns) <= {column.name for column in OPTIONAL}


def test_unknown_question_is_refused_with_nearest_name():
    with pytest.raises(InvalidParameter, match="found 'fellt', expected one of felt.*did you mean 'felt'"):
        catalogue.simulated().answer(Choose("fellt", (0, 1), ("no", "yes")))


def test_equal_pairs_are_called_different_at_expected_rate():
    from scipy.stats import norm

    observer, rng, n = catalogue.OBSERVERS["default"], np.random.default_rng(), 4000
    share = np.mean([observer.differ([5.0, 5.0], rng) for _ in range(n)])
    expected = 2 * norm.sf(observer.criterion) * (1 - observer.lapse_rate) + observer.lapse_rate / 2
    assert abs(share - expected) <= AT_1E_4 * math.sqrt(expected * (1 - expected) / n)


def test_unbiased_observer_has_criterion_near_zero():
    targets = np.random.default_rng().integers(1, 3, 4000)
    responses = np.where(np.random.default_rng().random(4000) < 0.75, targets, 3 - targets)
    bias = interval_bias(targets.tolist(), responses.tolist())
    assert abs(bias.criterion) <= AT_1E_4 * math.sqrt(2 * 0.75 * 0.25 / 2000) / 0.3178 / 2
    assert bias.p > 1e-4


def test_interval_bias_detects_constant_answers():
    bias = interval_bias([1, 2] * 50, [2] * 100)
    assert bias.share_correct == (0.0, 1.0)
    assert bias.criterion < -2
    assert bias.p < 1e-9


@pytest.mark.parametrize(
    ("targets", "responses", "words"),
    [
        ([], [], "expected equal numbers, at least 1"),
        ([1], [3], "trial 0: found target 1 and response 3"),
        ([1, 2], [1], "found 2 targets and 1 responses, expected equal numbers"),
    ],
)
def test_interval_bias_rejects_invalid_trials(targets, responses, words):
    with pytest.raises(InvalidParameter, match=words):
        interval_bias(targets, responses)


def test_interval_bias_has_no_p_with_few_trials():
    assert interval_bias([1, 2], [1, 2]).p is None
    assert interval_bias([1, 1], [1, 1], n_intervals=3).share_correct == (1.0, None, None)
