"""Refusals of study files with excessive sizes, before allocation."""

import io
import os
import resource
import subprocess
import sys

import pytest
from command_line import call
from study_texts import CONSTANT, TUTORIAL, changed, wired

from tactometry.config.toml import LARGEST_FILE, LONGEST_LIST, table_of
from tactometry.errors import InvalidFile, InvalidParameter, TactometryError, nearest
from tactometry.experiments.study.dry_run import check_duration, duration_s, plan
from tactometry.experiments.study.study_file import parse
from tactometry.protocols import ConstantStimuli, QuestPlus
from tactometry.protocols.bayesian.parameter_grid import ParameterGrid

LEVELS = "levels = [22, 28, 34, 40] "
QUEST = """kind = "quest_plus"
low = 10.0
high = 34.0
width_low = 4.0
width_high = 16.0
"""
CATCH = "catch_rate = 0.2"
VAST = [
    ({"repeats = 4": "repeats = 400000000"}, "found 400000000 of 4 levels, expected at most"),
    ({"repeats = 4": "repeats = 1000000000"}, "procedure.repeats: found 1000000000"),
    ({"repeats = 4": "repeats = 200000"}, "trials of all cells: found 1.6e+06"),
    (
        {LEVELS: f"levels = [{', '.join(map(str, range(100_000)))}] "},
        f"found a list of 100000 items, expected a study file with at most {LONGEST_LIST}",
    ),
    ({"[60, 240]": str(list(range(60, 2100)))}, "factors: found 2040 combinations of levels, expected at most 2000"),
    ({TUTORIAL: "k = 1\n" * 2_000_000}, f"expected a study file of at most {LARGEST_FILE}"),
    ({TUTORIAL: "".join(f"k{n} = 1\n" for n in range(80_000))}, "k0: found an unknown key"),
    ({TUTORIAL: f"a.{'.'.join('b' * 900)} = 1\n"}, "found tables more than 30 deep, expected a study file"),
    ({TUTORIAL: f"a = {'[' * 80}{']' * 80}\n"}, "found tables more than 30 deep, expected a study file"),
    ({CONSTANT: f"{QUEST}n_levels = 2000000000\n"}, "expected a whole number, at"),
    ({CONSTANT: f"{QUEST}n_levels = 9000\nn_widths = 9000\n"}, "levels times combinations of parameters: found"),
    (
        {CONSTANT: 'kind = "method_of_limits"\nlow = 1\nhigh = 9\nstep = 1\nn_series = 2000000000\n'},
        "procedure.n_series: found 2000000000, expected a whole number, at most 1000000",
    ),
    (
        {'"500 ms"': '"3 h"', "voltage_peak_v = 100.0": 'voltage_peak_v = 100.0\nduration_s = "unlimited"'},
        "stimulus.duration_s times the rate, in samples: found",
    ),
    (
        {f'kind = "yes_no"\n{CATCH}': 'kind = "rating"\nform = "sus"\nn_touches = 2000000000'},
        "task.n_touches: found 2000000000, expected a whole number, at most 1000",
    ),
]


@pytest.fixture
def little_memory():
    """Limit the address space to 2 GB more than in use."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm") as told:  # noqa: PTH123
        used = int(told.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + 2_000_000_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@pytest.mark.parametrize(("changes", "message"), VAST, ids=[message for _, message in VAST])
@pytest.mark.usefixtures("little_memory")
def test_vast_study_is_refused_before_it_is_built(tmp_path, capsys, changes, message):
    (tmp_path / "s.toml").write_text(changed(TUTORIAL, changes), "utf-8")
    status, said, _ = call(capsys, "run", tmp_path / "s.toml", "--participant", "P01", "--dry-run")
    assert status == 2
    assert message in said
    assert all(len(line) < 1500 for line in said.splitlines())
    assert len(said.splitlines()) <= 21


def test_variant_without_table_is_refused():
    with pytest.raises(InvalidFile, match=r"variants\.frequency_hz\.60\.touch: found 5, expected a table"):
        parse(f"{TUTORIAL}\n[variants.frequency_hz.60]\ntouch = 5\n".encode(), "s.toml")


@pytest.mark.parametrize(
    ("levels", "message"),
    [
        ('[60, "60"]', r"factors\.place\[1\]: found '60' twice"),
        ("[60, nan]", r"factors\.place\[1\]: found nan, expected a finite number or a text"),
        ('["a", ""]', r"factors\.place\[1\]: found '', expected a non-empty text of one line"),
        ('["a", "b\\n"]', r"factors\.place\[1\]: found 'b\\n', expected a non-empty text of one line"),
    ],
)
def test_levels_that_a_table_cannot_tell_apart_are_refused(levels, message):
    with pytest.raises(InvalidFile, match=message):
        wired(changed(TUTORIAL, {"frequency_hz = [60, 240]": f"place = {levels}"}))


def test_unasked_questionnaire_is_checked():
    with pytest.raises(InvalidParameter, match=r"s\.toml, forms\.mine\.\w+: found no such key"):
        wired(f'{TUTORIAL}\n[forms.mine]\ntitle = "x"\n')


def test_byte_order_mark_is_accepted(tmp_path, capsys):
    assert table_of(b"\xef\xbb\xbfa = 1\n", "s.toml", "a study file") == {"a": 1}
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + TUTORIAL.encode())
    assert call(capsys, "simulate", path, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")[0] == 0
    assert call(capsys, "validate", tmp_path / "d")[0] == 0


def test_long_value_is_abbreviated(tmp_path, capsys):
    path = tmp_path / "s.toml"
    for content in (
        TUTORIAL.replace('name = "tutorial"', f'name = "{"A" * 60_000}"'),
        TUTORIAL.replace("trial_s", "k" * 60_000),
        TUTORIAL.replace("catch_rate = 0.2", f"catch_rate = {list(range(9000))}"),
    ):
        path.write_text(content, "utf-8")
        status, said, _ = call(capsys, "run", path, "--participant", "P01", "--dry-run")
        assert status == 2
        assert "letters) ..." in said
        assert len(said) < 5000


def test_name_impossible_for_a_file_is_refused():
    with pytest.raises(InvalidFile, match="name: found 101 letters, expected at most 100"):
        parse(TUTORIAL.replace('"tutorial"', f'"{"a" * 101}"').encode(), "s.toml")
    assert parse(TUTORIAL.replace('"tutorial"', f'"{"a" * 100}"').encode(), "s.toml").name == "a" * 100


def test_hint_for_a_long_name_is_fast():
    assert nearest("x" * 1_000_000, ["y" * 1_000_000] * 10) == ""
    assert str(TactometryError("short words stay as they are")) == "short words stay as they are"


# --- how long a session lasts


def test_session_of_more_than_three_hours_is_reported(tmp_path, capsys):
    path = tmp_path / "s.toml"
    path.write_text(TUTORIAL.replace("repeats = 4", "repeats = 300"), "utf-8")
    status, said, out = call(capsys, "run", path, "--participant", "P01", "--dry-run")
    assert (status, said.count("\n")) == (0, 0)
    assert said.startswith("found a session of at most 4.17 hours, which is more than 3: plan fewer trials")
    assert "at most 250 minutes" in out


def test_session_over_a_day_is_refused_unless_simulated(tmp_path, capsys):
    path, out = tmp_path / "s.toml", tmp_path / "d"
    path.write_text(TUTORIAL.replace("trial_s = 5.0", "trial_s = 4000.0"), "utf-8")
    for more in (["--dry-run"], ["--rig", "console", "--out", out]):
        status, said, _ = call(capsys, "run", path, "--participant", "P01", *more)
        assert status == 2
        assert "procedure: found a session of at most 44.4 hours, expected at most 24; plan fewer" in said
    assert not out.exists()
    assert call(capsys, "run", path, "--participant", "P01", "--rig", "simulated", "--out", out)[0] == 0


def test_begun_session_continues_at_any_length(tmp_path, capsys, monkeypatch):
    path = tmp_path / "s.toml"
    path.write_text(TUTORIAL.replace("trial_s = 5.0", "trial_s = 4000.0"), "utf-8")
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 60))
    words = ("run", path, "--participant", "P01", "--rig", "console", "--out", tmp_path / "d", "--resume")
    status, said, _ = call(capsys, *words)
    assert status == 0
    assert "found a session of at most 44.4 hours" in said


def test_rests_count_and_what_ends_a_session_early_has_the_last_word():
    experiment = wired(TUTORIAL)
    blocks = plan(experiment, 1)
    plain_s = duration_s(experiment, blocks)
    rests = wired(changed(TUTORIAL, {CATCH: f'{CATCH}\nrest_after = 5\nrest_s = "1 min"'}))
    n_rests = sum((block.n_trials_at_most - 1) // 5 for block in blocks)
    assert duration_s(rests, blocks) == plain_s + 60 * n_rests
    short = wired(changed(TUTORIAL, {CATCH: f'{CATCH}\nlongest_s = "30 s"'}))
    assert duration_s(short, blocks) == 30 * len(blocks)
    early = wired(f'{TUTORIAL}\n[plan]\nlongest_s = "10 s"\n')
    assert duration_s(early, blocks) == 10 + max(5.0 * block.n_trials_at_most for block in blocks)
    assert check_duration(experiment, blocks) is None


# --- procedures of one's own


def test_procedures_refuse_what_no_memory_holds():
    with pytest.raises(InvalidParameter, match="found 1000001 of 1 level, expected at most 1000000 trials in all"):
        ConstantStimuli((1.0,), 1_000_001)
    many = tuple(map(float, range(500)))
    with pytest.raises(InvalidParameter, match="levels times combinations of parameters: found 1.25e"):
        QuestPlus(many, ParameterGrid(many, tuple(x + 1 for x in many)))


def test_commands_report_missing_memory():
    """It exceeds no size limit, but the process has little memory."""
    code = (
        "import resource, sys\n"
        "from tactometry import cli\n"
        "cli.tactometry.main = lambda *a, **k: bytearray(10**12)\n"
        "resource.setrlimit(resource.RLIMIT_AS, (2 * 10**9, 2 * 10**9))\n"
        "cli.main(['studies'])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("tactometry: found too little memory for this request")
