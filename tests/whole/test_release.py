"""Checks of `make release`: version, tag, changelog, wheel and audit."""

import importlib.util
import json
import re
import shutil
import sys

import pytest
from places import ROOT

from tactometry import __version__

PLACE = importlib.util.spec_from_file_location("release", ROOT / ".ci" / "release.py")
release = importlib.util.module_from_spec(PLACE)
PLACE.loader.exec_module(release)
TAG = f"v{__version__}"


@pytest.fixture
def source(tmp_path):
    (tmp_path / "tactometry").mkdir()
    shutil.copy(ROOT / "tactometry" / "__init__.py", tmp_path / "tactometry")
    (tmp_path / "CHANGELOG.md").write_text(f"## [Unreleased]\n\n## [{__version__}] - 2026-11-23\n", "utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("tags", "clean", "error", "sentence"),
    [
        ([], True, release.NotDone, f"git tag {TAG} makes it one"),
        (["v9.9.9"], True, release.Failed, f"found the tag v9.9.9, expected {TAG}"),
        ([TAG], False, release.Failed, "files that are not committed"),
    ],
)
def test_release_requires_its_tag_and_section_in_the_changelog(source, tags, clean, error, sentence):
    assert release.check_version(source, [TAG], clean=True) == __version__ == release.version_of(ROOT)
    with pytest.raises(error, match=re.escape(sentence)):
        release.check_version(source, tags, clean=clean)
    (source / "CHANGELOG.md").write_text("## [Unreleased]\n", "utf-8")
    with pytest.raises(release.Failed, match="rename \\[Unreleased\\]"):
        release.check_version(source, [TAG], clean=True)


@pytest.mark.parametrize(
    ("said", "error", "sentence"),
    [
        ("requests.exceptions.ConnectionError: no route", release.NotDone, "nothing was audited"),
        ("ServiceError: 503", release.NotDone, "nothing was audited"),
        ("Found 1 known vulnerability in 1 package", release.Failed, "known vulnerability"),
    ],
)
def test_audit_distinguishes_holes_from_unreachable_services(monkeypatch, said, error, sentence):
    def run(*_command):
        raise release.Failed(said)

    monkeypatch.setattr(release, "run", run)
    with pytest.raises(error, match=sentence):
        release.audit()


def test_wheel_holds_the_packages_without_links():
    tracked = ["tactometry/errors.py", "tactometry/stimuli", "stimuli/hybrid.py", "tests/conftest.py", "README.md"]
    assert release.wanted(tracked) == {"tactometry/errors.py", "tactometry/stimuli/hybrid.py"}


@pytest.mark.parametrize(
    ("raised", "words", "status", "expected"),
    [
        (None, [], 0, "nothing was published"),
        (release.Failed("a hole"), [], 1, "FAILED: a hole"),
        (release.Failed("a hole"), ["--unaudited"], 1, "FAILED: a hole"),
        (release.NotDone("not reached"), [], 1, "NOT DONE: not reached"),
        (release.NotDone("not reached"), ["--unaudited"], 0, "NOT DONE: not reached"),
    ],
)
def test_skipped_release_step_needs_its_option(monkeypatch, capsys, raised, words, status, expected):
    def audit():
        if raised is not None:
            raise raised
        return "no known hole"

    monkeypatch.setattr(release, "steps", lambda: iter([("audit", audit)]))
    monkeypatch.setattr(sys, "argv", ["release.py", *words])
    assert release.main() == status
    assert expected in capsys.readouterr().out


KNOWN, UNKNOWN = {"name": "a", "vulns": []}, {"name": "b", "skip_reason": "not found"}


def test_unknown_package_counts_as_unaudited(monkeypatch):
    """pip-audit itself exits with status 0 then."""
    monkeypatch.setattr(release, "run", lambda *_: json.dumps({"dependencies": [KNOWN, UNKNOWN]}))
    with pytest.raises(release.NotDone, match="1 of 2 packages are unknown to its service, such as b"):
        release.audit()
    monkeypatch.setattr(release, "run", lambda *_: json.dumps({"dependencies": [KNOWN]}))
    assert release.audit() == "pip-audit: no known hole in 1 packages"


def test_absent_python_is_reported(monkeypatch, tmp_path):
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    with pytest.raises(release.NotDone, match=r"no Python 3\.99"):
        release.python_of("3.99")


def test_one_licence_is_stated_for_all_files():
    assert 'SPDX-License-Identifier = "GPL-3.0-or-later"' in (ROOT / "REUSE.toml").read_text("utf-8")
    assert (ROOT / "LICENSE").read_bytes() == (ROOT / "LICENSES" / "GPL-3.0-or-later.txt").read_bytes()


def test_citation_states_the_version():
    assert f"\nversion: {__version__}\n" in (ROOT / "CITATION.cff").read_text("utf-8")


def test_the_list_of_materials_names_the_version():
    bill = {"metadata": {"component": {"name": "tactometry"}, "tools": []}, "components": [{"name": "numpy"}]}
    component = {"name": "tactometry", "version": "0.2.0"}
    assert release.with_version(bill, "0.2.0") == bill | {"metadata": {"component": component, "tools": []}}
