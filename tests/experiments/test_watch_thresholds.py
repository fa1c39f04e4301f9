"""The live page reports the thresholds of `analyse` for every task with a psychometric function."""

import json
import re

import pytest
from command_line import output
from followed_rule import with_row

from tactometry.analysis.tasks.kinds import CURVES
from tactometry.analysis.wording import interval_text
from tactometry.experiments.watch import view
from tactometry.experiments.watch.scenery import Scenery
from tactometry.experiments.watch.sight import Sight
from tactometry.experiments.watch.watcher import Watcher
from tactometry.session.progress import Progress
from tactometry.trials.trial import Trial

STUDIES = {
    "yes_no": "time-reversal-threshold",
    "forced_choice": "two-interval-forced-choice",
    "comparison": "texture-discrimination",
}


@pytest.mark.parametrize("task", CURVES)
def test_live_page_reports_threshold_of_analyse(tmp_path, capsys, task):
    data = tmp_path / "data"
    output(capsys, "simulate", STUDIES[task], "--participants", "1", "--seed", "3", "--out", data)
    found = json.loads(output(capsys, "analyse", data, "--json"))["thresholds"]
    rows = [row for row in found if row["status"] == "ok"]
    texts = [interval_text(row["threshold"], row["interval_low"], row["interval_high"]) for row in rows]
    page = Scenery(Watcher(data)).sections()
    words = re.sub("<[^>]*>", "", page["curve"])
    assert any(text in words for text in texts), (texts, words)


@pytest.mark.parametrize(
    ("task", "answer"), [("comparison", "more"), ("same_different", "different"), ("yes_no", "yes")]
)
def test_last_answer_has_word_of_task(task, answer):
    trial = Trial(1, 1, {}, "constant_stimuli", 43.0, "dB", task, 1, correct=False)
    shown = with_row(Progress(), trial)
    assert {row.name: row.value for row in view.where(Sight("a", progress=shown))}["Last trial"].endswith(f": {answer}")
    assert [mark.kind for mark in view.level_plots(shown)[0].marks] == ["yes"]
