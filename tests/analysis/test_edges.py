"""Tests of the limits of an analysis.

They cover the fewest participants, the trials that count, and uninformative answers.
"""

import pandas as pd
import pytest
from hard_cases import exact_case

from tactometry.analysis.anova.bounded_design import largest_complete
from tactometry.analysis.reading.quality import quality
from tactometry.analysis.reading.trials import read_trials
from tactometry.analysis.threshold.fitting import METHODS, fit


@pytest.mark.parametrize(("n_complete", "found"), [(2, False), (3, True)])
def test_a_sub_design_has_three_participants_at_least(n_complete, found):
    rows = [(f"P{n}", side, 1.0 if n <= n_complete or side == "a" else None) for n in (1, 2, 3, 4) for side in "ab"]
    table = pd.DataFrame(rows, columns=["participant", "side", "threshold"])
    part = largest_complete(table, dependent="threshold", within=["side"], subject="participant")
    assert (part is not None) == found


@pytest.mark.parametrize(
    ("sides", "left_out"),
    [
        (["abc"] * 4 + ["ab"] * 2, ("side = c",)),
        (["ab"] * 3 + ["bc"] * 3, ("participant P4", "participant P5", "participant P6", "side = c")),
    ],
    ids=["more participants", "earlier levels"],
)
def test_tied_sub_designs_are_resolved(sides, left_out):
    rows = [(f"P{n}", side, 1.0 if side in own else None) for n, own in enumerate(sides, 1) for side in "abc"]
    table = pd.DataFrame(rows, columns=["participant", "side", "threshold"])
    part = largest_complete(table, dependent="threshold", within=["side"], subject="participant")
    assert part.left_out == left_out


def test_quality_table_counts_each_row_once(tmp_path):
    """Three attempts of one trial; then a false alarm, a rejection, an unanswered and an invalid catch trial."""
    header = "participant,trial,force_n,procedure,level,task,response,valid,attempt,catch"
    rows = [
        "P01,1,1,x,3,yes_no,1,0,1,0",
        "P01,1,1,x,3,yes_no,1,0,2,0",
        "P01,1,1,x,3,yes_no,1,1,3,0",
        "P01,2,1,x,,yes_no,1,1,1,1",
        "P01,3,1,x,,yes_no,0,1,1,1",
        "P01,4,1,x,,yes_no,,1,1,1",
        "P01,5,1,x,,yes_no,1,0,1,1",
    ]
    file = tmp_path / "t.csv"
    file.write_text("\n".join([header, *rows]))
    (row,) = quality(read_trials(file)).to_dict("records")
    counts = {name: row[name] for name in row if name.startswith("n_")}
    assert counts == {
        "n_rows": 7,
        "n_practice": 0,
        "n_invalid": 3,
        "n_repeated": 2,
        "n_unanswered": 1,
        "n_catch": 2,
        "n_false_alarms": 1,
    }
    assert row["false_alarm_rate"] == 0.5


@pytest.mark.parametrize("n_yes", [[4, 4, 6, 6, 6, 6, 5], [6, 6, 3, 5, 7, 9, 6]])
def test_noisy_half_yes_answers_are_flat(n_yes):
    """The interval, twice as long as the levels, is not informative."""
    found = fit(list(range(7)), n_yes, [10] * 7, shape="normal", guess_rate=0.0, method="likelihood")
    assert found.status == "flat"


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [12, 100_000])
def test_half_yes_answers_are_flat_for_any_size(n, method):
    """The prior of the width alone would place the threshold at the middle."""
    found = fit(range(7), [n // 2] * 7, n, shape="normal", guess_rate=0.0, lapse_rate=0.0, method=method)
    assert (found.status, found.threshold) == ("flat", None)
    exact_case("half of the answers yes at every level", against="a status, no number")
