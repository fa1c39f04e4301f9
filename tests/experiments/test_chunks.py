"""Simulated tracks on the disk, identical after any interruption."""

import numpy as np
import pandas as pd
import pytest
from pyarrow import parquet

from tactometry.errors import InvalidFile
from tactometry.experiments.bias_study.batches import Respondents, TrackRun, fitted_tracks, write_tracks
from tactometry.protocols import Staircase

RULE = Staircase(36.0, (8.0, 4.0, 2.0), 0.0, 40.0, n_trials=30, n_reversals=30)
PEOPLE = Respondents(20.0, 3.0, 8.0, guess_rate=0.5, lapse_rate=0.02)


def run(seed=1):
    return TrackRun(RULE, PEOPLE, 5, seed, n_trials=30, size=40, n_together=2)


def contents(root):
    return {path.name: path.read_bytes() for path in (root / "tracks").glob("*")}


@pytest.fixture
def whole(tmp_path):
    list(write_tracks(run(), tmp_path / "whole"))
    return tmp_path / "whole"


def test_written_rows_equal_computed_batches(whole):
    table = pd.read_parquet(whole / "tracks")
    made = list(fitted_tracks(RULE, PEOPLE, range(5), 1, n_trials=30, size=40))
    assert table["threshold"].tolist() == np.concatenate([each.modes.thresholds for each in made]).tolist()
    assert table["true_threshold"].tolist() == np.concatenate([each.thresholds for each in made]).tolist()
    assert sorted(contents(whole)) == ["000000-000001.parquet", "000002-000003.parquet", "000004-000004.parquet"]


def test_every_file_is_marked_as_simulated(whole):
    for path in (whole / "tracks").glob("*"):
        assert parquet.read_schema(path).metadata[b"simulated"] == b"true"


def test_killed_run_continues_to_the_same_bytes(whole, tmp_path):
    begun = write_tracks(run(), tmp_path / "killed")
    first = next(begun)
    begun.close()
    stamp = first.stat().st_mtime_ns
    assert len(contents(tmp_path / "killed")) == 1
    paths = list(write_tracks(run(), tmp_path / "killed", resume=True))
    assert contents(tmp_path / "killed") == contents(whole)
    assert [path.name for path in paths] == sorted(contents(whole))
    assert first.stat().st_mtime_ns == stamp


def test_bytes_do_not_depend_on_work_order(whole, tmp_path):
    def backwards(function, jobs):
        return reversed([function(job) for job in reversed(list(jobs))])

    list(write_tracks(run(), tmp_path / "other", spread=backwards))
    assert contents(tmp_path / "other") == contents(whole)


@pytest.mark.parametrize(
    ("seed", "resume", "sentence"),
    [
        (1, False, "found this run of tracks, expected an empty folder; continue with --resume"),
        (2, True, "found seed 1, expected 2 as requested; choose another --out"),
    ],
)
def test_nonempty_folder_is_not_written_to(whole, seed, resume, sentence):
    before = contents(whole)
    with pytest.raises(InvalidFile, match=sentence):
        write_tracks(run(seed=seed), whole, resume=resume)
    assert contents(whole) == before
