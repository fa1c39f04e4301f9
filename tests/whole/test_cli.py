"""The command line: help, JSON, identical bytes and interruption."""

import io
import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import call, output, refused, status
from places import ROOT
from tables import contents, trial_rows

from tactometry.cli import COMMANDS, GROUPS, simulate as simulations
from tactometry.experiments.study.study_file import load

SIMULATED = ("simulate", "tutorial", "--participants", "4", "--seed", "5")


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    root = tmp_path_factory.mktemp("alone")
    assert status(*SIMULATED, "--out", root / "d") == 0
    return contents(root / "d")


PARTS = {"calibrate": ("gain", "force", "display", "responses")}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example(capsys, command):
    assert f"Example: tactometry {command}" in output(capsys, command, "--help")
    for words in ([command, part] for part in PARTS[command]) if command in PARTS else [[command]]:
        assert "--json" in output(capsys, *words, "--help")


@pytest.mark.parametrize("number", ["SIGTERM", "SIGHUP"])
def test_session_closes_on_termination_signals(capsys, number):
    ending = getattr(signal, number)
    # tests started by nohup inherit that SIGHUP is ignored
    usual = signal.signal(ending, signal.SIG_DFL)
    try:
        output(capsys, "studies")
        with pytest.raises(SystemExit) as ended:
            signal.raise_signal(ending)
    finally:
        signal.signal(ending, usual)
    assert ended.value.code == 128 + ending


def test_a_copied_study_runs(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output(capsys, "new", "tutorial", "--out", "mine.toml")
    output(capsys, "run", "mine.toml", "--participant", "P01", "--rig", "simulated", "--out", "d")
    assert "sound" in output(capsys, "validate", "d")
    assert "rows agree" in output(capsys, "replay", "d")


def test_dry_run_never_underestimates_a_session(capsys):
    planned = json.loads(output(capsys, "run", "time-reversal-patterns", "--participant", "P17", "--dry-run", "--json"))
    said = output(capsys, "run", "time-reversal-patterns", "--participant", "P17", "--dry-run")
    assert "at most 1 trial, 28 items" in said
    longest = int(said.rsplit("at most ", 1)[1].split()[0])
    assert longest - 1 < planned["minutes_at_most"] <= longest


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", "tutorial", "--participants", "1", "--seed", "1", "--out", "d"],
        ["run", "tutorial", "--participant", "P01", "--rig", "simulated", "--out", "e"],
        ["run", "tutorial", "--participant", "P01", "--dry-run"],
        ["new", "tutorial", "--out", "x.toml"],
    ],
    ids=lambda arguments: " ".join(arguments[:2]),
)
def test_results_come_as_json(tmp_path, capsys, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    assert json.loads(output(capsys, *arguments, "--json"))


def test_validate_replay_and_analyse_give_json(tmp_path, capsys):
    output(capsys, "simulate", "tutorial", "--participants", 2, "--seed", 1, "--out", tmp_path / "d")
    assert json.loads(output(capsys, "validate", tmp_path / "d", "--json"))["defects"] == []
    sessions = json.loads(output(capsys, "replay", tmp_path / "d", "--json"))
    assert [session["complete"] for session in sessions] == [True, True]
    assert json.loads(output(capsys, "analyse", tmp_path / "d", "--json"))


@pytest.mark.parametrize("options", [["--jobs", "2"], ["--jobs", "-1"]])
def test_processes_change_no_byte(tmp_path, alone, options):
    assert status(*SIMULATED, "--out", tmp_path, *options) == 0
    assert contents(tmp_path) == alone


def test_a_cluster_changes_no_byte(tmp_path, alone):
    pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
    script = (
        "import distributed, sys\n"
        "from tactometry.cli import main\n"
        "if __name__ == '__main__':\n"
        "    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:\n"
        "        main([*sys.argv[1:], '--scheduler', cluster.scheduler_address])\n"
    )
    (tmp_path / "cluster.py").write_text(script)
    words = [sys.executable, tmp_path / "cluster.py", *SIMULATED, "--out", tmp_path / "d"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert contents(tmp_path / "d") == alone


def test_silent_scheduler_is_a_failed_device(tmp_path, capsys):
    pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
    code, said, _ = call(capsys, *SIMULATED, "--out", tmp_path / "d", "--scheduler", "nonsense://nowhere")
    assert code == 3
    assert "no Dask scheduler responds at 'nonsense://nowhere'" in said


def test_endless_nonsense_stops_a_console_session(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO("perhaps\n" * 100))
    words = ("run", "tutorial", "--participant", "P01", "--rig", "console", "--out", tmp_path / "d")
    code, said, out = call(capsys, *words)
    assert code == 1
    assert out.count("expected 0 or 1, found 'perhaps'") == 20
    assert "20 invalid answers in a row" in said


@pytest.fixture
def interruptible():
    """Enable interrupts, which a background job and its children ignore."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_interrupted_simulation_leaves_complete_files_and_resumes(tmp_path, capsys):
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    words = ["simulate", "electrovibration-threshold", "--participants", "2", "--seed", "5"]
    output(capsys, *words, "--out", whole)
    child = subprocess.Popen(
        [sys.executable, "-m", "tactometry", *words, "--out", stopped], stderr=subprocess.PIPE, text=True
    )
    while not list(stopped.glob("data/*.csv")):
        assert child.poll() is None
        time.sleep(0.01)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate()
    assert (child.returncode, said.strip()) == (
        130,
        "tactometry: interrupted; recorded data are safe: continue with --resume",
    )
    output(capsys, *words, "--out", stopped, "--resume")
    kept = {path: content for path, content in contents(stopped).items() if "_interruptions" not in path.name}
    assert kept == contents(whole)


def test_sine_variant_reports_censored_cells_as_bounds(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output(capsys, "new", "electrovibration-threshold", "--out", "sine.toml")
    study = Path("sine.toml").read_text("utf-8")
    Path("sine.toml").write_text(study.replace('kind = "amplitude_modulated"', 'kind = "sine"'), "utf-8")
    output(capsys, "simulate", "sine.toml", "--participants", 3, "--seed", 2, "--out", "d")
    out = output(capsys, "analyse", "d")
    assert re.search(r" 30 │ .*of 3: \d above the", out)
    assert "95 % interval between participants" in out
    assert re.search(r"analysis of variance with censored values\s+\(by default", out)
    assert re.search(r"with\s+censored\s+values\s+leaves\s+out\s+frequency\s+=\s+30\s+Hz", out)


@pytest.mark.parametrize(
    ("study", "n_participants"),
    [("tutorial", 4), pytest.param(simulations.DEMO_STUDY, simulations.N_PARTICIPANTS, marks=pytest.mark.slow)],
)
def test_demo_runs_from_simulation_to_report(tmp_path, capsys, monkeypatch, study, n_participants):
    is_long = study == simulations.DEMO_STUDY
    monkeypatch.setattr(simulations, "DEMO_STUDY", study)
    monkeypatch.setattr(simulations, "N_PARTICIPANTS", n_participants)
    out = output(capsys, "demo", "--out", tmp_path / "demo")
    assert (tmp_path / "demo" / "report.html").stat().st_size > 100_000
    assert "report:" in out
    assert len(list((tmp_path / "demo" / "data").glob("*.csv"))) == n_participants
    if is_long:
        drawn = points(tmp_path / "demo" / "report.html")
        shown = points(ROOT / "docs" / "readme" / "light.svg")
        assert len(shown) > 200
        assert np.abs(shown[:, None] - drawn).max(axis=2).min(axis=1).max() < 0.5  # of a point


def points(drawing):
    found = re.findall(r'<use [^>]*x="([\d.]+)" y="([\d.]+)"', drawing.read_text("utf-8"))
    return np.array(found, dtype=float)


def test_readme_figure_is_equal_in_light_and_dark():
    light, dark = (ROOT / "docs" / "readme" / name for name in ("light.svg", "dark.svg"))
    np.testing.assert_array_equal(points(light), points(dark))
    assert "#ffffff" not in dark.read_text("utf-8")


@pytest.mark.slow
def test_reused_processes_write_into_current_folder(tmp_path, monkeypatch):
    """Worker processes are reused, and keep the working folder of the first command."""
    for name in ("here", "there"):
        folder = tmp_path / name
        folder.mkdir()
        monkeypatch.chdir(folder)
        assert status("simulate", "tutorial", "--participants", "2", "--seed", "1", "--jobs", "2", "--out", "d") == 0
        assert len(list((folder / "d" / "data").glob("*_data.csv"))) == 2


# --- first use

POWER = ("power", "tutorial", "--effect", "frequency_hz: 6 dB", "--participants", "4", "--most", "2")
PEOPLE = ("simulate", "tutorial", "--participants", "1")
PERSON = ("run", "tutorial", "--participant", "P01", "--rig", "simulated")


def test_help_lists_each_command_in_one_group(capsys) -> None:
    assert sorted(name for names in GROUPS.values() for name in names) == sorted(COMMANDS)
    said = output(capsys, "--help")
    headings = [said.index(f"{heading}:\n") for heading in GROUPS]
    assert headings == sorted(headings)
    assert all(re.search(rf"^  {command} +\w", said, re.MULTILINE) for command in COMMANDS)


def test_new_writes_to_standard_output(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert output(capsys, "new", "tutorial", "--out", "-").encode() == load("tutorial")[1]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", [PEOPLE, PERSON])
def test_drawn_seed_is_printed_and_repeats_the_data(tmp_path, capsys, command) -> None:
    _, said, _ = call(capsys, *command, "--out", tmp_path / "a")
    seed = re.search(r"seed: (\d+) ", said)[1]
    output(capsys, *command, "--out", tmp_path / "b", "--seed", seed)
    tables = [trial_rows(tmp_path / name) for name in ("a", "b")]
    assert tables[0] == tables[1]


def test_power_needs_no_seed(capsys) -> None:
    code, said, text = call(capsys, *POWER)
    assert code == 0
    seed = re.search(r"seed: (\d+) ", said)[1]
    assert f"seed {seed}" in text


def test_resume_of_drawn_seed_names_the_option(tmp_path, capsys) -> None:
    said = refused(capsys, *PEOPLE, "--out", tmp_path / "d", "--resume")
    assert "--seed: found none, expected the seed that the interrupted run printed" in said


def test_resume_reports_when_there_is_nothing_to_resume(tmp_path, capsys) -> None:
    code, said, _ = call(capsys, *PERSON, "--out", tmp_path / "d", "--resume")
    assert code == 0
    assert f"--resume: {tmp_path / 'd'} contains no session 1 of P01 to resume; it begins now" in said
