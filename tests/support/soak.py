"""Size of the tests: full with `make soak`."""

import os

SOAK = os.environ.get("TACTOMETRY_SOAK") == "1"
