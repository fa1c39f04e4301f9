"""Easy trials in adaptive procedures: places and learning."""

import numpy as np
import pytest
from catalogue import PROCEDURES
from study_texts import TUTORIAL, refusal, wired

from tactometry.experiments.study.kinds import PROCEDURES as KINDS
from tactometry.protocols import Staircase
from tactometry.protocols.bayesian.quest_plus import SharedQuestPlus
from tactometry.protocols.procedures.easy import EasyTrials, with_easy_trials

ADAPTIVE = [kind for kind, known in KINDS.items() if known.takes_easy_trials]


def answered(procedure, answer):
    """Return kinds and levels of all trials, and the procedure at its end."""
    trials = []
    while not procedure.finished:
        trials.append((procedure.is_easy, procedure.level))
        procedure = procedure.after(answer(procedure.level))
    return trials, procedure


@pytest.mark.parametrize("kind", ADAPTIVE)
def test_easy_trials_are_a_share_of_all_trials(kind):
    rule = PROCEDURES[kind]
    trials, ended = answered(with_easy_trials(rule, 0.2, 40.0, np.random.default_rng(1)), lambda level: level > 11)
    places = [n for n, (is_easy, _) in enumerate(trials) if is_easy]
    assert [n // 5 for n in places[: len(trials) // 5]] == list(range(len(trials) // 5))
    assert {level for is_easy, level in trials if is_easy} == {40.0}
    assert len(trials) <= ended.n_trials_at_most == rule.n_trials_at_most


def test_a_staircase_does_not_learn_from_easy_trials():
    rule = Staircase(20.0, (4.0,), 0.0, 40.0, n_trials=40, n_reversals=40)
    alone, _ = answered(rule, lambda level: level > 11)
    trials, ended = answered(with_easy_trials(rule, 0.2, 40.0, np.random.default_rng(1)), lambda level: 11 < level < 40)
    others = [trial for trial in trials if not trial[0]]
    assert others == alone[: len(others)]
    assert (len(trials), ended.ending, len(ended.view.responses)) == (40, "trials", 32)


@pytest.mark.parametrize("kind", ["quest", "quest_plus", "psi"])
def test_bayesian_procedures_learn_from_easy_trials(kind):
    track = EasyTrials(PROCEDURES[kind], 40.0, frozenset([0]))
    direct = PROCEDURES[kind].after(0, delivered=40.0)
    assert track.after(0).threshold == direct.threshold


def test_shared_tracks_learn_from_easy_trials_of_others():
    one, two = SharedQuestPlus(PROCEDURES["quest_plus"], ("a", "b")).procedures()
    easy, other = (EasyTrials(each, 40.0, frozenset([0])) for each in (one, two))
    moved = easy.after(0)
    assert other.learning_from(moved).view.pool is moved.view.pool
    staircase = EasyTrials(PROCEDURES["staircase"], 40.0, frozenset([0]))
    assert staircase.learning_from(moved) is staircase


QUEST = "start = 20\nstart_sd = 12\nlow = -20\nhigh = 40\nstep = 0.5\ntarget = 0.6\nguess_rate = 0.05"
STAIRCASE = "start = 34\nsteps = [8]\nlow = -10\nhigh = 40"


def study_with(procedure):
    before, rest = TUTORIAL.partition("[procedure]")[0], TUTORIAL.partition("[limits]")[2]
    return f"{before}[procedure]\n{procedure}\n\n[limits]{rest}"


@pytest.mark.parametrize(
    ("procedure", "why"),
    [
        (f'kind = "quest"\n{QUEST}\neasy_share = 0.7', "procedure.easy_share: found 0.7"),
        (f'kind = "quest"\n{QUEST}\neasy_level = 40', "without easy_share"),
        (f'kind = "staircase"\n{STAIRCASE}\neasy_share = 0.1\neasy_level = 41', "from -10 to 40"),
        (f'kind = "staircase"\n{STAIRCASE}\nesy_share = 0.1', "did you mean 'easy_share'?"),
        ('kind = "constant_stimuli"\nlevels = [1, 2]\nrepeats = 2\neasy_share = 0.1', "levels do not depend"),
    ],
)
def test_impossible_easy_trials_are_refused(procedure, why):
    assert why in refusal(study_with(procedure))


def test_easy_trials_follow_the_seed_alone():
    experiment = wired(study_with(f'kind = "staircase"\n{STAIRCASE}\neasy_share = 0.1'))
    first, again, other = (
        [part.tracks[0].procedure.places for part in experiment.parts(1, np.random.default_rng(seed))]
        for seed in (1, 1, 2)
    )
    assert first == again != other
