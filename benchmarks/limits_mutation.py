"""A mutation run over limits.py: each check is taken away once, and the tests of the limits must fail.

Run: python benchmarks/limits_mutation.py
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from measured import tell

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("tactometry", "stimuli", "protocols", "analysis", "experiments", "tests")
LIMITS = Path("tactometry", "safety", "limits.py")
TESTS = ("tests/kernel/test_limits.py", "tests/kernel/test_filtered_limits.py")
SOURCE = (ROOT / LIMITS).read_text(encoding="utf-8")


def mutants() -> dict[str, str]:
    """Sources with one thing changed, by what was changed."""
    found = {}
    for line in re.findall(r"^ +_check\(\".*\)$", SOURCE, re.M):
        found[f"no {line.split(chr(34))[1]}"] = SOURCE.replace(line, line[: len(line) - len(line.lstrip())] + "pass")
    changes = {
        "no unit": ('signal.unit != "V"', "False"),
        "stated nowhere": ("        self.check_stated(load)\n", ""),
        "none missing": ("        if missing:", "        if False:"),
        "neither current nor charge": ('missing.insert(0, "current_peak_a or charge_peak_c")', "pass"),
        "an electrode needs no duty": ('"electrode": ("duration_s", "duty",', '"electrode": ("duration_s",'),
        "an electrode needs no session": ('"duty", "session_s"),\n    "piezo"', '"duty"),\n    "piezo"'),
        "an electrode needs no duration": ('"electrode": ("duration_s", ', '"electrode": ('),
        "patches need no duration": ('"piezo": ("duration_s", ', '"piezo": ('),
        "patches need no displacement": ('"duration_s", "displacement_peak_m"', '"duration_s"'),
        "a signal as long as it likes": ("return LONGEST_SIGNAL_S if", "return 1e9 if"),
        "a stop as late as it likes": ("return STOP_WITHIN_S if", "return 1e9 if"),
        "a window as long as it likes": ("self.duty_window_s, LONGEST_WINDOW_S)", "0.0, LONGEST_WINDOW_S)"),
        "a force as large as it likes": ("target_n * (1 + tolerance)", "target_n"),
        "the looser of two forces": ('("duty", "duty_window_s")]', '("duty", "duty_window_s", "force_peak_n")]'),
        "the looser of two charges of a session": (
            '("duty", "duty_window_s")]',
            '("duty", "duty_window_s", "charge_session_c")]',
        ),
        "displacement of unknown gain": ("and load.displacement_m_per_v is None", "and False"),
        "any value of a limit": ('positive("Limits", ', "dict("),
        "a duty above 1": ("self.duty is None or self.duty <= 1", "True"),
        "a generous rounding": ("ROUNDING = 1e-12", "ROUNDING = 1e-3"),
        "never above": ("if not value <= limit", "if False and value <= limit"),
        "NaN passes": ("if not value <= limit * (1 + tolerance)", "if value > limit * (1 + tolerance)"),
        "the new signal does not count": (
            "exposure.after(begin_s, duration_s, self.duty_window_s).played_s",
            "exposure.played_s",
        ),
        "half a window is remembered": ("first_s = end_s - window_s", "first_s = end_s - window_s / 2"),
        "the session begins at zero": ("begin_s + duration_s - exposure.opened_s", "begin_s + duration_s"),
        "a signal may begin late": ("begin_s + duration_s - exposure.opened_s", "begin_s - exposure.opened_s"),
        "no voltage between samples": ("filtered_peak_v(signal, bound)", "0.0"),
        "no current between samples": ("load.filtered_current_a(signal, bound, rise_s)", "0.0"),
        "no charge between samples": ("load.filtered_charge_c(signal, bound, rise_s)", "0.0"),
        "no displacement between samples": ("load.filtered_displacement_m(signal, bound)", "0.0"),
        "a generous tolerance between samples": ("limit, unit, cure, TOLERANCE)", "limit, unit, cure, 1.0)"),
        "a bound that is too large between samples": ("peak(limit * (1 + TOLERANCE))", "peak(limit * 2)"),
        "the looser of two": ("return min((value for", "return max((value for"),
        "the shorter window": ("longest_s = max(", "longest_s = min("),
    }
    return found | {what: _replaced(*change) for what, change in changes.items()}


def _replaced(old: str, new: str) -> str:
    assert old in SOURCE, old
    return SOURCE.replace(old, new)


def passes(tree: Path, source: str) -> bool:
    (tree / LIMITS).write_text(source, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *TESTS]
    env = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(command, cwd=tree, env=env, capture_output=True, check=False).returncode == 0


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder)
        shutil.copy(ROOT / "pyproject.toml", tree)
        for name in FOLDERS:
            shutil.copytree(ROOT / name, tree / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
        assert passes(tree, SOURCE), "the tests fail without a mutation"
        verdicts = {what: "SURVIVED" if passes(tree, mutant) else "killed" for what, mutant in mutants().items()}
    for what, verdict in verdicts.items():
        print(f"{verdict:<9} {what}", flush=True)
    killed = list(verdicts.values()).count("killed")
    tell(f"of {len(verdicts)} mutants of the limits, killed", killed, "mutants", at_least=len(verdicts))


if __name__ == "__main__":
    main()
