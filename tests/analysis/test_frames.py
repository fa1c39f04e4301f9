"""Tests of screen frames in the quality table."""

import analysis_data
import numpy as np
import pandas as pd
import pytest

from tactometry.analysis.pipeline import analyse
from tactometry.analysis.reading.quality import frames, with_frames
from tactometry.errors import InvalidFile
from tactometry.session.event import COLUMNS, Event


def event(kind, **facts) -> str:
    return "\t".join(Event(kind, 1.0, facts=facts).cells())


def trial(n, dropped, longest_s) -> str:
    return event("trial", trial=1, n_frames=n, n_dropped_frames=dropped, frame_interval_max_s=longest_s)


@pytest.fixture
def data_set(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "journals").mkdir()
    truth = {(f"P0{p}", (0.5,)): 20.0 for p in (1, 2, 3)}
    analysis_data.write_study(tmp_path / "data" / "all_data.csv", truth, ["force_n"], rng=np.random.default_rng(), n=4)
    interrupted = [trial(500, 20, 0.08), event("remark", text="late"), trial(500, 0, 0.017)]
    for code, rows in {"P01": interrupted, "P02": [trial(1000, 0, 0.018)]}.items():
        text = "\n".join(["\t".join(column.name for column in COLUMNS), *rows]) + "\n"
        (tmp_path / "journals" / f"participant-{code}_session-1_study-x_events.tsv").write_text(text)
    return tmp_path


def test_dropped_frames_are_summed_with_warning(data_set) -> None:
    found = analyse(data_set)
    quality = found.tables["quality"].set_index("participant")
    assert quality.loc["P01", ["n_frames", "n_dropped_frames"]].tolist() == [1000, 20]
    assert quality["frame_interval_max_s"]["P01"] == 0.08
    assert quality["n_dropped_frames"]["P02"] == 0
    assert quality["n_dropped_frames"].isna()["P03"]
    assert "more than 1 % of screen frames dropped: P01 20 of 1020" in found.warnings


def test_quality_is_unchanged_without_events(tmp_path) -> None:
    quality = pd.DataFrame({"participant": ["A"]})
    assert with_frames(quality, frames(tmp_path)) is quality
    assert frames(tmp_path / "trials.csv").empty


def test_a_damaged_file_of_events_is_refused(data_set) -> None:
    next((data_set / "journals").iterdir()).write_text("onset\tduration\n1\t2\n")
    damaged = r"_events.tsv: found a damaged file of events \('trial_type'\), expected the columns"
    with pytest.raises(InvalidFile, match=damaged):
        frames(data_set)
