"""Built-in scene files."""

from pathlib import Path

from tactometry.arguments.require import expect
from tactometry.errors import nearest

FOLDER = Path(__file__).parent


def names() -> list[str]:
    """Return the names of the built-in scenes.

    >>> "electrovibration-panel" in names()
    True
    """
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def path_of(scene: str) -> Path:
    """Return the file of a scene name or path. Raises `InvalidParameter`."""
    if scene in names():
        return FOLDER / f"{scene}.toml"
    hint = nearest(scene, names())
    expect(Path(scene).is_file(), "FILE", repr(scene), f"a path or one of {', '.join(names())}{hint}")
    return Path(scene)
