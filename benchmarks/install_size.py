"""Sizes of an installation on the disk: `python benchmarks/install_size.py [PAGE]` also updates docs/how_to/install.md.

The core is installed into an empty virtual environment under the constraints, then one extra after the other. The size
of a package includes packages that only it requires; pip and setuptools are not counted.
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
    "numpy": "arrays: every signal, every table",
    "scipy": "distributions, special functions, filters, searches: the physics and the fits",
    "numba": "machine code of loops: the finger that sticks and slips, the plate in time, thousands of tracks at once",
    "pandas": "tables of trials and of results",
    "statsmodels": "analyses of variance of three factors and of groups, mixed models",
    "pingouin": "analyses of variance within participants, corrections, tests of assumptions",
    "matplotlib": "figures, and the report",
    "pillow": "images on pages, height maps of textures",
    "msgspec": "journals and study files, read strictly",
    "annotated-types": "constraints of arguments and keys, as annotations",
    "tomlkit": "a bench file that is changed keeps its comments (`calibrate --write`)",
    "click": "the command line",
    "rich": "tables and progress in the terminal",
    "jinja2": "the pages of reports and of `watch`",
    "joblib": "work on several cores (`--jobs`)",
    "portalocker": "one session at a time writes a journal",
    "platformdirs": "the folder for what outputs of the computer played",
    "threadpoolctl": "threads of linear algebra: told by `check`, held while time is measured",
}
EXTRAS = {
    "power": "Parquet files: `power --out`, `write_tracks`",
    "audio": "sound cards as outputs, microphones as sensors",
    "serial": "sensors on a serial line",
    "lsl": "sensors of Lab Streaming Layer",
    "ni": "NI cards",
    "hdf5": "impulse responses in HDF5 files",
    "film": "films of scenes",
    "watch": "the experimenter's page of a session",
    "cluster": "`--scheduler`: work on a Dask cluster",
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
"""Each package with its MB and its requirements."""


class Environment:
    """An empty virtual environment for our packages."""

    def __init__(self, place: Path) -> None:
        subprocess.run([sys.executable, "-m", "venv", place], check=True)
        self.python = place / "bin" / "python"

    def pip(self, *command: str) -> None:
        pinned = ["--constraint", str(ROOT / "constraints.txt")]
        subprocess.run([self.python, "-m", "pip", *command, *pinned], check=True, capture_output=True, cwd=ROOT)

    def downloaded_mb(self) -> float:
        """Return the size of the wheels of the core."""
        with tempfile.TemporaryDirectory() as folder:
            self.pip("download", "--dest", folder, ".")
            return sum(file.stat().st_size for file in Path(folder).iterdir() if OURS not in file.name) / 1e6

    def packages(self) -> Packages:
        said = subprocess.run([self.python, "-c", INSTALLED], check=True, capture_output=True, text=True).stdout
        found = json.loads(said).items()
        sizes = {canonicalize_name(name): (size / 1e6, needs(wanted)) for name, (size, wanted) in found}
        return {name: of for name, of in sizes.items() if name not in {"pip", "setuptools", OURS}}

    def total_mb(self) -> float:
        return sum(size for size, _ in self.packages().values())


def needs(requirements: list[str]) -> set[str]:
    """Return the names of requirements that apply here, without extras."""
    wanted = map(Requirement, requirements)
    return {canonicalize_name(one.name) for one in wanted if not one.marker or one.marker.evaluate({"extra": ""})}


def brought(packages: Packages, direct: list[str]) -> dict[str, list[str]]:
    """Return the packages that come with each direct one, and with none before it."""
    left, found = packages.keys() - set(direct), {}
    for name in direct:
        waiting, mine = list(packages[name][1]), set()
        while waiting:
            one = waiting.pop()
            if one in left - mine:
                mine.add(one)
                waiting += packages[one][1]
        found[name], left = sorted(mine), left - mine
    return found


def core_table(packages: Packages) -> str:
    direct = [canonicalize_name(Requirement(text).name) for text in PROJECT["dependencies"]]
    comes = brought(packages, direct)
    size = {name: packages[name][0] + sum(packages[other][0] for other in comes[name]) for name in direct}
    names = sorted(direct, key=lambda name: -size[name])
    rows = [(name, megabytes(size[name]), ", ".join(comes[name]), REASONS[name]) for name in names]
    return table(("package", "MB", "with", "what for"), rows)


def extras_table(environment: Environment) -> str:
    """Return each extra with its size in addition to those above it."""
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
    """Return a page with the tables between its marks."""
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
