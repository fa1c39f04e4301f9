"""CPU time of `tactometry --help`, of a table of keys and of the imports of an analysis, beside a bare interpreter and
one that imports pandas.

Interleaved, one warm-up each; CPU time is user plus system time of the child. The limit is 0.3 s, of keys and an import
1 s.
"""

import os
import statistics
import subprocess
import sys
from pathlib import Path

from measured import ratios, tell

RUNS = 15
LIMIT_S = 0.3
IMPORT_LIMIT_S = 1.0
IMPORTS = {
    "import tactometry.analysis": "import tactometry.analysis",
    "import of fit": "from tactometry.analysis.threshold import fit",
}
COMMANDS = {
    "tactometry --help": [str(Path(sys.executable).with_name("tactometry")), "--help"],
    "tactometry keys touch.slide": [str(Path(sys.executable).with_name("tactometry")), "keys", "touch.slide"],
    "python -c pass": [sys.executable, "-c", "pass"],
    "python -c 'import pandas'": [sys.executable, "-c", "import pandas"],
    **{name: [sys.executable, "-c", code] for name, code in IMPORTS.items()},
}


def cpu_s(command: list[str]) -> float:
    """User and system time (s) of a child that must succeed."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"{' '.join(command)}: exit status {child.returncode}")
    return usage.ru_utime + usage.ru_stime


def measured() -> dict[str, list[float]]:
    """CPU times (s) of each command, interleaved."""
    for command in COMMANDS.values():
        cpu_s(command)
    rounds = [{name: cpu_s(command) for name, command in COMMANDS.items()} for _ in range(RUNS)]
    return {name: [each[name] for each in rounds] for name in COMMANDS}


def main() -> None:
    times = measured()
    reference = statistics.median(times["tactometry --help"])
    print(f"Python {sys.version.split()[0]}, {os.cpu_count()} cores, {RUNS} runs each, limit {LIMIT_S} s")
    for name, each in times.items():
        median = statistics.median(each)
        spread = f"min {min(each):.3f}  max {max(each):.3f}"
        print(f"{name:26} median {median:.3f} s  {spread}  ratio {median / reference:.2f}")
    tell("tactometry --help", times["tactometry --help"], "s", at_most=LIMIT_S)
    for name in IMPORTS:
        tell(name, times[name], "s", at_most=IMPORT_LIMIT_S)
        tell(f"{name} over that of pandas", ratios(times[name], times["python -c 'import pandas'"]))
    keys = "tactometry keys touch.slide"
    tell(keys, times[keys], "s", at_most=IMPORT_LIMIT_S)
    tell(f"{keys} over an import of pandas", ratios(times[keys], times["python -c 'import pandas'"]))
    tell("tactometry --help over a bare interpreter", ratios(times["tactometry --help"], times["python -c pass"]))


if __name__ == "__main__":
    main()
