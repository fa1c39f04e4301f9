"""Whether the tests run at full size: `make soak` asks for it."""

import os

SOAK = os.environ.get("TACTOMETRY_SOAK") == "1"
