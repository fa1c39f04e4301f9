"""Studies run and simulated by a script equal those of the commands."""

import pytest
from command_line import output

import tactometry
from tactometry.errors import InvalidParameter


def test_script_records_what_command_records(tmp_path, capsys):
    tactometry.run("tutorial", "P01", out=tmp_path / "script", rig="simulated", seed=1, tell=lambda text: None)
    output(
        capsys, "run", "tutorial", "--participant", "P01", "--rig", "simulated", "--seed", 1, "--out", tmp_path / "c"
    )
    one, other = (sorted((tmp_path / name / "data").glob("*.csv")) for name in ("script", "c"))
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in other]


def test_simulated_trials_are_analysed_without_files(tmp_path):
    trials = tactometry.simulate("tutorial", 2, seed=1)
    assert set(trials.rows["participant"]) == {"P01", "P02"}
    tactometry.run("tutorial", "P01", out=tmp_path, rig="simulated", seed=1, tell=lambda text: None)
    alone = trials.rows[trials.rows["participant"] == "P01"]
    assert len(tactometry.read_trials(tmp_path).rows) == len(alone)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"rig": "simulatd"}, "run.rig: found 'simulatd', expected .*'simulated'"),
        ({"session": 1.5}, "run.session: found 1.5, expected a whole number"),
        ({"participant": 1}, "run.participant: found 1, expected a text"),
        ({"seed": "one"}, "run.seed: found 'one', expected a whole number"),
    ],
)
def test_run_refuses_wrong_argument_before_recording(tmp_path, wrong, message) -> None:
    given = {"study": "tutorial", "participant": "P01", "out": tmp_path / "data", "rig": "simulated", **wrong}
    with pytest.raises(InvalidParameter, match=message):
        tactometry.run(**given)
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("wrong", [{"n_participants": 2.5}, {"n_participants": "2"}, {"seed": "a"}, {"n_jobs": 0}])
def test_simulate_refuses_wrong_argument(wrong) -> None:
    with pytest.raises(InvalidParameter, match="found (2.5|'2'|'a'|0), expected"):
        tactometry.simulate(**{"study": "tutorial", "n_participants": 2, "seed": 1, **wrong})


def test_analyse_accepts_one_factor_as_text(tmp_path) -> None:
    tactometry.run("tutorial", "P01", out=tmp_path, rig="simulated", seed=1, tell=lambda text: None)
    assert tactometry.analyse(tmp_path, within="frequency_hz").factors == ("frequency_hz",)


@pytest.mark.parametrize("short", [{"participants": ["A"] * 3}, {"conditions": {"force_n": [1.0, 2.0]}}])
def test_hierarchical_fit_refuses_rows_of_other_number(short) -> None:
    given = {"participants": ["A"] * 4, "conditions": {"force_n": [1.0] * 4}, "shape": "normal", "guess_rate": 0.0}
    with pytest.raises(InvalidParameter, match=r"found \d rows, expected 4, one for each level"):
        tactometry.fit_hierarchical([1, 2, 3, 4], [0, 3, 6, 9], 10, **(given | short))
