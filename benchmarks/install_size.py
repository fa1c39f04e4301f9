"""Measure the disk size of an installation: `python benchmarks/install_size.py [PAGE]`.

With PAGE, docs/how_to/install.md is updated.

The core and then each extra are installed into an empty virtual environment, with the constraints. The size of a
package includes packages that no other package requires. pip and setuptools are excluded.
"""

import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tactometry.experiments.harness import table

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
REASONS = {
    "numpy": "arrays: signals and tables",
    "scipy": "distributions, special functions, filters, searches: the physics and the fits",
    "numba": "compiled loops: stick-slip friction, plate motion, thousands of tracks at once",
    "pandas": "tables of trials and results",
    "statsmodels": "analyses of variance with three factors or groups, mixed models",
    "pingouin": "analyses of variance within participants, corrections, tests of assumptions",
    "matplotlib": "figures and reports",
    "pillow": "images on pages, height maps of textures",
    "msgspec": "strict reading of journals and study files",
    "annotated-types": "annotations with constraints of arguments and keys",
    "tomlkit": "editing of bench files that keeps comments (`calibrate --write`)",
    "click": "the command line",
    "rich": "tables and progress in the terminal",
    "jinja2": "the pages of reports and of `watch`",
    "joblib": "computation on several cores (`--jobs`)",
    "portalocker": "locks, so that only one session writes a journal",
    "platformdirs": "folder for the record of played signals",
    "threadpoolctl": "threads of linear algebra: shown by `check`, limited during time measurements",
}
EXTRAS = {
    "power": "Parquet files: `power --out`, `write_tracks`",
    "audio": "sound cards as outputs, microphones as sensors",
    "serial": "sensors on a serial line",
    "lsl": "sensors via Lab Streaming Layer",
    "ni": "NI cards",
    "hdf5": "impulse responses in HDF5 files",
    "film": "films of scenes",
    "watch": "the experimenter's page of a session",
    "cluster": "computation on a Dask cluster (`--scheduler`)",
    "window": "sessions in a PsychoPy window",
}
INSTALLED = """
import json
from importlib.metadata import distributions
def size(file):
    path = file.locate()
    return path.stat().st_blocks * 512 if path.is_file() else 0
print(json.dumps({d.name: [sum(map(size, d.files or [])), d.requires or []] for d in distributions()}))
"""
OURS = "tactometry"
BEGIN, END = "<!-- sizes: begin -->", "<!-- sizes: end -->"
Packages = dict[str, tuple[float, set[str]]]
"""Size (MB) and requirements of each package."""


class Environment:
    """Virtual environment for Tactometry and its packages, empty at first."""

    def __init__(self, place: Path) -> None:
        subprocess.run([sys.executable, "-m", "venv", place], check=True)
        self.python = place / "bin" / "python"

    def pip(self, *command: str) -> None:
        pinned = ["--constraint", str(ROOT / "constraints.txt")]
        subprocess.run([self.python, "-m", "pip", *command, *pinned], check=True, capture_output=True, cwd=ROOT)

    def downloaded_mb(self) -> float:
        """Return the size (MB) of the core's wheels."""
        with tempfile.TemporaryDirectory() as folder:
            self.pip("download", "--dest", folder, ".")
            return sum(file.stat().st_size for file in Path(folder).iterdir() if OURS not in file.name) / 1e6

    def packages(self) -> Packages:
        output = subprocess.run([self.python, "-c", INSTALLED], check=True, capture_output=True, text=True).stdout
        result = json.loads(output).items()
        sizes = {canonicalize_name(name): (size / 1e6, needs(requires)) for name, (size, requires) in result}
        return {name: of for name, of in sizes.items() if name not in {"pip", "setuptools", OURS}}

    def total_mb(self) -> float:
        return sum(size for size, _ in self.packages().values())


def needs(requirements: list[str]) -> set[str]:
    """Return the names of requirements that apply to this environment, without extras."""
    parsed = map(Requirement, requirements)
    return {canonicalize_name(one.name) for one in parsed if not one.marker or one.marker.evaluate({"extra": ""})}


def brought(packages: Packages, direct: list[str]) -> dict[str, list[str]]:
    """Return the packages that each direct requirement adds to those before it."""
    left, result = packages.keys() - set(direct), {}
    for name in direct:
        waiting, mine = list(packages[name][1]), set()
        while waiting:
            one = waiting.pop()
            if one in left - mine:
                mine.add(one)
                waiting += packages[one][1]
        result[name], left = sorted(mine), left - mine
    return result


def core_table(packages: Packages) -> str:
    direct = [canonicalize_name(Requirement(text).name) for text in PROJECT["dependencies"]]
    comes = brought(packages, direct)
    size = {name: packages[name][0] + sum(packages[other][0] for other in comes[name]) for name in direct}
    names = sorted(direct, key=lambda name: -size[name])
    rows = [(name, megabytes(size[name]), ", ".join(comes[name]), REASONS[name]) for name in names]
    return table(("package", "MB", "with", "what for"), rows)


def extras_table(environment: Environment) -> str:
    """Return a table of extras, with the size that each adds to those above it."""
    rows, before = [], environment.total_mb()
    for extra, reason in EXTRAS.items():
        environment.pip("install", f".[{extra}]")
        now = environment.total_mb()
        rows.append((f"`{extra}`", megabytes(now - before), reason))
        before = now
    return table(("extra", "MB more", "what for"), rows)


def megabytes(size: float) -> str:
    return f"{size:.0f}" if size >= 0.5 else "under 1"


def page_text(text: str, tables: str) -> str:
    """Return a page with updated tables between its marks."""
    head, _, rest = text.partition(BEGIN)
    return f"{head}{BEGIN}\n\n{tables}\n\n{END}{rest.partition(END)[2]}"


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        environment = Environment(Path(folder) / "venv")
        downloaded = environment.downloaded_mb()
        environment.pip("install", ".")
        python = f"Python {sys.version_info.major}.{sys.version_info.minor}, {sys.platform}"
        whole = f"The core: {environment.total_mb():.0f} MB on the disk, {downloaded:.0f} MB to download ({python})."
        tables = "\n\n".join([whole, core_table(environment.packages()), extras_table(environment)])
    print(tables)
    for page in map(Path, sys.argv[1:]):
        page.write_text(page_text(page.read_text(encoding="utf-8"), tables), encoding="utf-8")


if __name__ == "__main__":
    main()
