"""Versions and digests that identify how data were produced."""

import hashlib
import platform

DISTRIBUTIONS = ("tactometry", "numpy", "scipy", "pandas", "msgspec", "psychopy")


def versions() -> dict[str, str]:
    """Return versions of Python, system and packages that affect the data."""
    from importlib import metadata  # slow to load

    by_name = {"python": platform.python_version(), "system": platform.system(), "machine": platform.machine()}
    for name in DISTRIBUTIONS:
        try:
            by_name[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return by_name


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def digest_of(content: bytes) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256."""
    return sha256(content)[:16]
