"""What a recording was made with."""

import hashlib
import platform

DISTRIBUTIONS = ("tactometry", "numpy", "scipy", "pandas", "msgspec", "psychopy")


def versions() -> dict[str, str]:
    """Versions of Python, the system and the packages that data depend on; what is not installed is left out."""
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
    """The first 16 hexadecimal digits of the SHA-256: what a journal says of samples that are kept elsewhere."""
    return sha256(content)[:16]
