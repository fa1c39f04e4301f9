"""Run studies on the documented benches in docs/reference/devices.md."""

import re
import tomllib
from datetime import date

import pytest
from command_line import call
from places import DOCS

from tactometry.experiments.bench.bench_file import load_bench, parse_bench
from tactometry.experiments.bench.preflight import _strongest
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import builtin, load
from tactometry.safety.limits import Limits

STUDY = Limits(200.0)
TODAY = date(2026, 11, 21)
PAGE = (DOCS / "reference" / "devices.md").read_text(encoding="utf-8")
BENCHES = re.findall(r"```toml\n(.*?)```", PAGE, re.S)
CLAIMS = re.findall(r"^\| ((?:`[a-z-]+`(?:, )?)+) \| the one.* \| (?:`(.*)`)? ?\|$", PAGE, re.M)
CLAIMED = [
    (study, bench, line)
    for bench, (studies, line) in zip(BENCHES, CLAIMS, strict=True)
    for study in re.findall(r"`(.*?)`", studies)
]


def test_docs_contain_a_bench_file_for_each_study():
    panels = {"tutorial", "electrovibration-threshold", "grating-roughness"}
    plates = {"time-reversal-threshold", "time-reversal-patterns", "force-loss"}
    expected = [panels, plates | {"time-reversal-localisation"}, plates | {"hybrid-button"}]
    assert [set(re.findall(r"`(.*?)`", studies)) for studies, _ in CLAIMS] == expected
    assert set(builtin()) == {study for study, _, _ in CLAIMED}
    outputs = [parse_bench(tomllib.loads(text)).devices(STUDY, TODAY).output for text in BENCHES]
    assert [output.name.split()[0] for output in outputs] == ["audio", "ni", "packed"]


def each_study_at_once(claimed):
    """Return the first bench of each study; `make check` runs all of them."""
    seen = [study for study, _, _ in claimed]
    marks = [pytest.mark.slow if study in seen[:place] else () for place, study in enumerate(seen)]
    return [pytest.param(*case, marks=mark) for case, mark in zip(claimed, marks, strict=True)]


@pytest.mark.parametrize(("study", "text", "line"), each_study_at_once(CLAIMED))
def test_documented_bench_runs_its_studies(tmp_path, capsys, study, text, line):
    """Copy the study, add the documented line, then dry-run and check it."""
    (tmp_path / "bench.toml").write_text(text, encoding="utf-8")
    assert call(capsys, "new", study, "--out", tmp_path / "mine.toml")[0] == 0
    mine = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(mine.replace("[stimulus]\n", f"[stimulus]\n{line}\n"), encoding="utf-8")
    at = [tmp_path / "mine.toml", "--bench", tmp_path / "bench.toml", "--out", tmp_path / "d"]
    assert call(capsys, "run", *at, "--participant", "P01", "--dry-run")[0] == 0
    bench, experiment = load_bench(tmp_path / "bench.toml"), wire(load(str(at[0]))[0], study)
    output = bench.devices(experiment.study.limits, TODAY).output
    findings = list(_strongest(output, experiment, bench))
    assert len(findings) >= 1
    assert [each for each in findings if not each.fine] == []


def test_study_is_refused_without_the_documented_line(tmp_path):
    bench, experiment = parse_bench(tomllib.loads(BENCHES[0])), wire(load("tutorial")[0], "tutorial")
    findings = list(_strongest(bench.devices(experiment.study.limits, TODAY).output, experiment, bench))
    assert len(findings) == 2
    expected = "with rate_hz 20000, expected 192000; state this rate_hz in [stimulus] of the study (or its setup)"
    assert all(expected in each.found for each in findings)
