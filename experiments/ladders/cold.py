"""The first call of a rung in a process of its own: `python -m tactometry.experiments.ladders.cold LADDER PLACE`."""

import os
import subprocess
import sys

from ..cost.measure import run_once
from . import problem_of

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def cold_s(ladder: str, place: int) -> float:
    """Processor time (s) of the first call of a rung, by its place, where nothing has been computed before.

    What is imported and loaded for the call counts, what its ladder imports does not.

    Raises
    ------
    subprocess.CalledProcessError
        If the call fails there.
    """
    asked = [sys.executable, "-m", __name__, ladder, str(place)]
    environment = os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(sys.path)}
    told = subprocess.run(asked, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout
    return float(told.split()[-1])


if __name__ == "__main__":
    print(run_once(problem_of(sys.argv[1]).rungs[int(sys.argv[2])].run)[0])
