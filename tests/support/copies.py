"""Function calls in a forked copy of this process."""

import json
import os


def in_a_copy(of):
    """Return the JSON result of a function without arguments."""
    read, write = os.pipe()
    child = os.fork()
    if not child:
        with os.fdopen(write, "w") as answer:
            json.dump(of(), answer)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as heard:
        answer = json.load(heard)
    os.waitpid(child, 0)
    return answer
