"""Samples of an HDF5 file, read in a separate process.

`python -P hdf5.py FILE LARGEST` writes NPZ to standard output, or an error to standard error. `-P` is needed because
modules in this folder have names of the standard library.
"""

import io
import math
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np

READ_WITHIN_S: Final = 30.0
"""Time limit. A valid file of the largest size takes seconds (unverified default)."""


def as_npz(path: Path, largest_bytes: int) -> bytes:
    """Return samples, rate and quantity of a file as bytes of an NPZ file.

    Raises `ImportError` without h5py, `ValueError` if the file is damaged, refers to other files, or has more than
    `largest_bytes`.
    """
    if find_spec("h5py") is None:
        raise ImportError("h5py")
    command = [sys.executable, "-P", __file__, str(path), str(largest_bytes)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=READ_WITHIN_S, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(
            f"found a file that the HDF5 library did not read within {READ_WITHIN_S:g} s, expected a valid file"
        ) from None
    if done.returncode:
        words = done.stderr.decode("utf-8", "replace").splitlines()
        raise ValueError(words[-1] if words else "found a file that crashed the HDF5 library, expected a valid file")
    return done.stdout


def _own_dataset(file: Any, name: str, largest_bytes: int) -> Any:
    """Return a dataset whose samples are in this file and not too large."""
    import h5py  # type: ignore[import-untyped, unused-ignore]

    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise ValueError(f"{name}: found no dataset, or a link, expected a dataset of this file")
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{name}: found a group, expected a dataset of this file")
    if dataset.is_virtual or dataset.external:
        raise ValueError(f"{name}: found values of another file, expected a dataset of this file")
    n_bytes = math.prod(dataset.shape or (0,)) * dataset.dtype.itemsize
    if n_bytes > largest_bytes:
        raise ValueError(f"{name}: found {n_bytes} bytes, expected at most {largest_bytes}")
    return dataset


def _npz_bytes(path: str, largest_bytes: int) -> bytes:
    import h5py  # type: ignore[import-untyped, unused-ignore]

    with h5py.File(path, "r") as file:
        arrays = {name: np.asarray(_own_dataset(file, name, largest_bytes)) for name in ("samples", "rate_hz")}
        if "quantity" in file:
            arrays["quantity"] = np.array(str(_own_dataset(file, "quantity", largest_bytes).asstr()[()]))
    written = io.BytesIO()
    np.savez(written, **arrays)  # type: ignore[arg-type]
    return written.getvalue()


def _main(path: str, largest_bytes: str) -> int:
    try:
        sys.stdout.buffer.write(_npz_bytes(path, int(largest_bytes)))
    except Exception as error:  # h5py raises various errors for damaged bytes
        print(" ".join(f"{error or type(error).__name__}".split()), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(_main(*sys.argv[1:]))
