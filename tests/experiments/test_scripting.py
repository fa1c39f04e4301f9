"""Studies that a script runs and simulates are those that the commands record."""

from command_line import output

import tactometry


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
