"""Tests of figures drawn in other processes."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from tactometry.cli.analyse import command

RECORDED = Path(__file__).parents[1] / "recorded"


def files_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", ["localisation", "yes-no"])
def test_report_and_figures_ignore_number_of_jobs(tmp_path: Path, name: str) -> None:
    for n_jobs in ("1", "2"):
        (tmp_path / n_jobs).mkdir()
        places = ["--report", str(tmp_path / n_jobs / "r.html"), "--figures", str(tmp_path / n_jobs / "figures")]
        done = CliRunner().invoke(command, [str(RECORDED / name), "--jobs", n_jobs, *places])
        assert done.exit_code == 0, done.output
    assert files_of(tmp_path / "1") == files_of(tmp_path / "2")
    assert any(file.endswith(".png") for file in files_of(tmp_path / "1"))
