"""Validators of BIDS, where they are installed."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from patience import LONGEST_PROGRAM_S

VALIDATOR = shutil.which("bids-validator-deno", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


def issues_of(root, program=VALIDATOR):
    """Return a validator's issues for a copy of the data set on disk."""
    where = {**os.environ, "NO_COLOR": "1", "DENO_NO_UPDATE_CHECK": "1"}
    with tempfile.TemporaryDirectory() as folder:
        copy = shutil.copytree(root, Path(folder) / "bids")
        words = [str(program), str(copy), "--json"]
        done = subprocess.run(words, capture_output=True, text=True, check=False, env=where, timeout=LONGEST_PROGRAM_S)
    assert "{" in done.stdout, done.stderr
    return json.JSONDecoder().raw_decode(done.stdout[done.stdout.index("{") :])[0]["issues"]
