"""Build and check a release in dist/: `make release`. Nothing is published.

The version is stated only in `tactometry/__init__.py`, so that a clone without tags, an sdist and a copy without git
give the same build. A release is a commit with the tag `v` and the version; without this tag, the output says that
the build is not a release. Each step prints done, FAILED or NOT DONE. A step that is not done (because a Python
version is missing, or the audit service cannot be reached) makes the exit status 1, unless an option permits it.
"""

import argparse
import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "dist"
PYTHONS = ("3.11", "3.12")
NEWEST = "3.13"
WINGS = ("stimuli", "protocols", "analysis", "experiments")
CLEAN = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
UNREACHED = ("ConnectionError", "Max retries", "ServiceError", "HTTPError", "timed out")
"""What pip-audit says where its service does not answer."""


class NotDone(Exception):  # noqa: N818
    """A step could not be tried; the message is the reason."""


class Failed(Exception):  # noqa: N818
    """A step found an error."""


def run(*command: str | Path, cwd: Path = ROOT) -> str:
    """Run a program, and return what it prints.

    Raises
    ------
    Failed
        If its exit status is not 0; the message is its last lines.
    """
    done = subprocess.run(
        [str(word) for word in command], cwd=cwd, env=CLEAN, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise Failed((done.stdout + done.stderr).strip()[-2000:])
    return done.stdout


def tool(name: str) -> Path:
    """Return the path of a program in the current environment."""
    return Path(sys.executable).with_name(name)


def version_of(root: Path) -> str:
    """Return the version in the source."""
    tree = ast.parse((root / "tactometry" / "__init__.py").read_text(encoding="utf-8"))
    values = [node.value for node in tree.body if isinstance(node, ast.Assign) and _is_version(node.targets[0])]
    return str(ast.literal_eval(values[0]))


def _is_version(target: ast.expr) -> bool:
    return isinstance(target, ast.Name) and target.id == "__version__"


def check_version(root: Path, tags: list[str], *, clean: bool) -> str:
    """Check that source, tag and changelog have one version, and with `clean` that nothing is uncommitted."""
    version = version_of(root)
    if not tags:
        raise NotDone(f"this commit has no tag: a build of {version}, and no release; git tag v{version} makes it one")
    if f"v{version}" not in tags:
        raise Failed(f"found the tag {', '.join(tags)}, expected v{version} as in tactometry/__init__.py")
    if not clean:
        raise Failed("found files that are not committed, expected what the tag names")
    if not re.search(
        rf"^## \[{re.escape(version)}\]", (root / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE
    ):
        raise Failed(f"CHANGELOG.md: found no section [{version}], expected one: rename [Unreleased]")
    return version


def version() -> str:
    tags = run("git", "tag", "--points-at", "HEAD").split()
    return check_version(
        ROOT, [tag for tag in tags if tag.startswith("v")], clean=not run("git", "status", "--porcelain")
    )


def build() -> str:
    """Build the sdist, and the wheel from the sdist, so that a file missing there is noticed."""
    shutil.rmtree(DIST, ignore_errors=True)
    run(tool("python"), "-m", "build", "--outdir", DIST, ".")
    return ", ".join(f"{path.name} ({path.stat().st_size / 1e6:.1f} MB)" for path in sorted(DIST.iterdir()))


def metadata() -> str:
    run(tool("twine"), "check", "--strict", *sorted(DIST.iterdir()))
    return "twine check --strict"


def wanted(tracked: list[str]) -> set[str]:
    """Return the paths that the wheel should contain."""
    own = {name for name in tracked if name.split("/")[0] in ("tactometry", *WINGS) and "/" in name}
    links = {f"tactometry/{room}" for room in WINGS}
    return {name if name.startswith("tactometry/") else f"tactometry/{name}" for name in own - links}


def contents() -> str:
    """Check that the wheel contains exactly these files, and the sdist what builds it."""
    held = {name for name in zipfile.ZipFile(only("*.whl")).namelist() if ".dist-info/" not in name}
    differ = held ^ wanted(run("git", "ls-files").splitlines())
    if differ:
        raise Failed(f"{len(differ)} files are in the wheel or in the tree alone, such as {sorted(differ)[0]}")
    with tarfile.open(only("*.tar.gz")) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    missing = {"LICENSES/GPL-3.0-or-later.txt", "README.md", "pyproject.toml", "setup.py"} - names
    if missing:
        raise Failed(f"the sdist lacks {', '.join(sorted(missing))}")
    return f"{len(held)} files in the wheel, as in the tree"


def only(pattern: str) -> Path:
    (path,) = DIST.glob(pattern)
    return path


def licences() -> str:
    run(tool("reuse"), "lint", "--quiet")
    return "reuse lint"


def python_of(minor: str) -> Path:
    """Return a working Python of this version, from the path, pyenv or uv."""
    ours = os.environ.get("PYENV_ROOT", str(Path.home() / ".pyenv"))
    candidates = [shutil.which(f"python{minor}"), *sorted(Path(ours, "versions").glob(f"{minor}.*/bin/python"))]
    for candidate in filter(None, candidates):
        asked = [str(candidate), "-c", "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"]
        told = subprocess.run(asked, capture_output=True, text=True, check=False)
        if told.stdout.strip() == minor:
            return Path(candidate)
    raise NotDone(f"no Python {minor} with venv runs here")


def install(minor: str) -> str:
    """Install the wheel in an empty environment with hashed packages, and run a session and its analysis."""
    with TemporaryDirectory() as folder:
        place = Path(folder)
        run(python_of(minor), "-m", "venv", place / "v")
        pip = (place / "v/bin/python", "-m", "pip", "install", "-q")
        run(*pip, "--require-hashes", "-r", ROOT / "requirements/core.txt")
        run(*pip, "--no-deps", only("*.whl"))
        program = place / "v/bin/tactometry"
        told = run(program, "--version").strip()
        run(program, "simulate", "tutorial", "--participants", "2", "--seed", "1", "--out", "d", cwd=place)
        run(program, "validate", "d", cwd=place)
        run(program, "analyse", "d", "--report", "d/report.html", cwd=place)
        if minor == PYTHONS[0]:
            bill_of_materials(place / "v/bin/python")
        return f"{told} on {run(place / 'v/bin/python', '--version').strip()}: simulated, validated, analysed"


def bill_of_materials(python: Path) -> None:
    """Write the CycloneDX list of materials of the environment with the wheel."""
    cyclonedx = (tool("cyclonedx-py"), "environment", "--pyproject", ROOT / "pyproject.toml", "--output-reproducible")
    path = DIST / "tactometry.cdx.json"
    run(*cyclonedx, "--output-file", path, python)
    bill = with_version(json.loads(path.read_text(encoding="utf-8")), version_of(ROOT))
    path.write_text(json.dumps(bill, indent=2) + "\n", encoding="utf-8")


def with_version(bill: dict[str, Any], version: str) -> dict[str, Any]:
    """Add the version, which the tool only reads from pyproject.toml, to a list of materials."""
    metadata = bill["metadata"]
    return {**bill, "metadata": {**metadata, "component": {**metadata["component"], "version": version}}}


def materials() -> str:
    """Write the list of materials if the wheel was installed."""
    path = DIST / "tactometry.cdx.json"
    if not path.exists():
        raise NotDone(f"the wheel was not installed on {PYTHONS[0]}")
    return f"{path.name} (CycloneDX), {len(json.loads(path.read_text(encoding='utf-8'))['components'])} packages"


def resolves() -> str:
    asked = ("--python-version", NEWEST, "--no-header", "--output-file", os.devnull, "pyproject.toml")
    run(tool("uv"), "pip", "compile", "--quiet", *asked)
    return f"the core on {NEWEST}"


def audit() -> str:
    """Report known vulnerabilities of the pinned packages, and packages unknown to the service."""
    plain = ("--progress-spinner", "off", "--disable-pip", "--no-deps", "--format", "json")
    try:
        told = json.loads(run(tool("pip-audit"), *plain, "-r", ROOT / "constraints.txt"))
    except Failed as failure:
        if any(word in str(failure) for word in UNREACHED):
            last = str(failure).splitlines()[-1]
            raise NotDone(f"its service was not reached, so that nothing was audited ({last:.120})") from None
        raise
    found = told["dependencies"]
    skipped = [package["name"] for package in found if "skip_reason" in package]
    if skipped:
        raise NotDone(f"{len(skipped)} of {len(found)} packages are unknown to its service, such as {skipped[0]}")
    return f"pip-audit: no known hole in {len(found)} packages"


def steps() -> Iterator[tuple[str, Callable[[], str]]]:
    yield "version", version
    yield "build", build
    yield "metadata", metadata
    yield "contents", contents
    yield "licences", licences
    for minor in PYTHONS:
        yield f"install {minor}", lambda minor=minor: install(minor)
    yield f"resolve {NEWEST}", resolves
    yield "materials", materials
    yield "audit", audit


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--untagged", action="store_true", help="a build that is no release will do")
    parser.add_argument("--unaudited", action="store_true", help="an audit that cannot be made is excused")
    said = parser.parse_args()
    excused = {"version": said.untagged, "audit": said.unaudited}
    wrong = 0
    for name, step in steps():
        try:
            print(f"{name:14}{step()}", flush=True)
        except NotDone as reason:
            wrong += not excused.get(name, False)
            print(f"{name:14}NOT DONE: {reason}", flush=True)
        except Failed as reason:
            wrong += 1
            print(f"{name:14}FAILED: {reason}", flush=True)
    print(f"{DIST}: nothing was published" if not wrong else f"{wrong} steps failed or were not done; do not publish")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
