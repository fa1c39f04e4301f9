"""Which files of a data set hold something of one participant.

Three kinds. *Own* files are named for the participant, or are a journal of theirs under another name. *Derived* files
were made from the trials of several: reports, tables, figures, exports. All of them go, as a mean holds whoever entered
it, and are made anew from who remains. What somebody else put into the folder stays, and is told where it names the
code.
"""

import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tactometry.errors import InvalidFile
from tactometry.files.durable import drafts, read_file
from tactometry.records.data_set import PARTS, keys_of
from tactometry.records.description import NAME
from tactometry.records.erasures import RECORD
from tactometry.records.head import heads

STUDY: Final = "study.toml"
DERIVED: Final = frozenset((".csv", ".gz", ".htm", ".html", ".json", ".jsonl", ".pdf", ".png", ".svg", ".tsv"))
"""How names of files end that `analyse`, `show` and `export` write; scripts and notes of people end otherwise."""
EXPORTED: Final = frozenset(("README.md", "CHANGES.md", "columns.toml", "trials.R"))
"""What `export` writes besides."""
_FIGURE: Final = (".csv", ".png", ".svg")
_OF_TRIAL: Final = re.compile(r"trial-\d+\.(png|pdf|svg)")
_BEGINNINGS: Final = {NAME: b"", "columns.toml": b"# tactometry analyse", "trials.R": b"# Reads trials.csv"}
"""Files by which the folder of an export is known, and how they begin."""
_SHORT: Final = re.compile(r"[A-Za-z]{1,2}")
_KEYS: Final = ("participant", "subject", "sub")


@dataclass(frozen=True)
class Left:
    """A file that stays although it may hold something of the participant; `names` if the code stands in it."""

    file: str
    why: str
    names: bool


@dataclass(frozen=True)
class ErasurePlan:
    """What is to be erased: `own` and `derived` files, and what stays and is to be looked at."""

    journals: tuple[Path, ...]
    own: tuple[Path, ...]
    derived: tuple[Path, ...]
    left: tuple[Left, ...]

    @property
    def files(self) -> tuple[Path, ...]:
        """All that goes, journals last: while one is there, the others can be found and made anew."""
        return (*self.derived, *self.own, *self.journals)


def plan(root: Path, code: str, begun: Collection[str] = ()) -> ErasurePlan:
    """What is to be erased of the participant `code`; `begun` are names that an interrupted erasure had to erase.

    Raises
    ------
    InvalidFile
        If something in the folder may not be read.
    """
    files = list(_walk(root))
    own = [path for path in files if _is_own(root, path, code)]
    of_others = [path for path in files if path not in own and _is_of_set(root, path)]
    beside = {path: _content(path) for path in files if path not in own and path not in of_others}
    derived = set(_derived(root, code, beside)) | {path for path in beside if _name(root, path) in begun}
    stays = {path: content for path, content in beside.items() if path not in derived}
    return ErasurePlan(
        tuple(path for path in own if _is_journal(root, path)),
        tuple(path for path in own if not _is_journal(root, path)),
        tuple(sorted(derived)),
        (
            *_left_behind(root, own),
            *_left_beside(root, code, stays),
            *_left_of_others(root, code, of_others),
            *_unsearched(root, code),
        ),
    )


def _name(root: Path, path: Path) -> str:
    return path.relative_to(root).as_posix()


def _walk(root: Path) -> Iterator[Path]:
    """Every file and link of a data set, sorted; not those of hidden folders, and of data sets of their own within."""
    for folder, folders, files in os.walk(root, onerror=_refuse):
        here = Path(folder)
        folders[:] = sorted(name for name in folders if not name.startswith(".") and not _is_a_set(here / name))
        links = [name for name in folders if (here / name).is_symlink()]
        yield from (here / name for name in sorted([*files, *links]))


def _refuse(error: OSError) -> None:
    raise InvalidFile(f"{error.filename}: cannot be read ({error.strerror}), expected a folder to read")


def _is_a_set(folder: Path) -> bool:
    return (folder / "journals").is_dir()


def is_named_for(name: str, code: str) -> bool:
    """Whether a path, in its folders or its file, has the participant's code under a key of Psych-DS or BIDS.

    >>> is_named_for("data/participant-P1_session-1_study-a_data.csv", "P1"), is_named_for("bids/sub-P10/x.tsv", "P1")
    (True, False)
    """
    keys = "|".join(_KEYS)
    return re.search(rf"(?:^|[/._])(?:{keys})-{re.escape(code)}(?=[/._]|$)", name) is not None


def _is_own(root: Path, path: Path, code: str) -> bool:
    return is_named_for(_name(root, path), code) or (_is_journal(root, path) and _whose(path) == code)


def _is_journal(root: Path, path: Path) -> bool:
    return path.parent == root / "journals" and path.suffix == ".jsonl" and "_interruptions" not in path.stem


def _whose(journal: Path) -> str | None:
    """The participant that the head of a journal names."""
    with suppress(InvalidFile):
        return next((head.participant for head in heads(journal)), None)
    return None


def _is_of_set(root: Path, path: Path) -> bool:
    """Whether it is a file that all share, or one of another participant's session."""
    if path.parent == root:
        return path.name in (NAME, STUDY, RECORD) or path in drafts(root, RECORD)
    return path.parent.parent == root and path.parent.name in PARTS and "participant" in keys_of(path.stem)


def _content(path: Path) -> bytes:
    """What is searched: nothing of a link, and no text where a file is too large, a pipe, or may not be read."""
    if path.is_symlink():
        return b""
    try:
        return read_file(path, "a file to search")
    except InvalidFile:
        return b"\0"


def says(content: bytes, code: str) -> bool:
    """Whether the code stands in it as a word of its own.

    >>> says(b"sub-P1,3", "P1"), says(b"P10,3", "P1")
    (True, False)
    """
    return re.search(_word(code), content) is not None


def _word(code: str) -> bytes:
    # behind a line break or a tabulator that JSON writes as two letters too
    return rf"(?:(?<![A-Za-z0-9])|(?<=\\[nrt])){re.escape(code)}(?![A-Za-z0-9])".encode()


def mention(content: bytes, code: str) -> str | None:
    """The code as it stands there, in capitals or small letters: of one or two letters alone only as it is, as such a
    word means much else.

    >>> mention(b"p1 was ill", "P1"), mention(b"p10 was ill", "P1"), mention(b"a word", "A")
    ('p1', None, None)
    """
    found = re.search(_word(code), content, 0 if _SHORT.fullmatch(code) else re.IGNORECASE)
    return found and found[0].decode()


def _derived(root: Path, code: str, beside: Mapping[Path, bytes]) -> Iterator[Path]:
    """Reports, tables, figures and exports."""
    outputs = {path for path in beside if path.suffix.lower() in DERIVED}
    naming = {path for path in outputs if says(beside[path], code) or says(path.name.encode(), code)}
    reports = {path for path in outputs if path.with_name(f"{path.stem}_tables").is_dir()}
    stems = {path.with_suffix("") for path in naming | reports}
    folders = {path.parent for path in naming} | {path.with_name(f"{path.stem}_tables") for path in reports}
    folders |= {path.parent for path in outputs if all(path.with_suffix(end) in outputs for end in _FIGURE)}
    exports = tuple(_exports(root, beside))
    for path in beside:
        in_export = any(path.is_relative_to(folder) for folder in exports)
        of_folder = in_export or path.parent in folders - {root} or _OF_TRIAL.fullmatch(path.name)
        is_output = path in outputs and (of_folder or path.with_suffix("") in stems)
        if is_output or (in_export and path.name in EXPORTED):
            yield path


def _exports(root: Path, beside: Mapping[Path, bytes]) -> Iterator[Path]:
    """The folders below a data set that `tactometry export` wrote."""
    for path, content in beside.items():
        if path.name in _BEGINNINGS and content.startswith(_BEGINNINGS[path.name]) and path.parent != root:
            yield path.parent


def _left_behind(root: Path, own: Collection[Path]) -> Iterator[Left]:
    """What links of the participant lead to: the link goes, and what was recorded stays elsewhere."""
    for path in own:
        if path.is_symlink():  # to what may be on a disk that is not there now, too
            there = os.path.realpath(path)
            yield Left(_name(root, path), f"is a link; erase {there} too, which it leads to", names=True)


def _left_beside(root: Path, code: str, stays: Mapping[Path, bytes]) -> Iterator[Left]:
    """What others wrote, and what cannot be searched."""
    for path, content in stays.items():
        name = _name(root, path)
        place = _place(content, lambda line: mention(line, code))
        if place is not None:
            yield Left(name, f"names {place}; edit or remove it", names=True)
        elif (of_name := mention(name.encode(), code)) is not None:
            yield Left(name, f"is named for {of_name}; look at it", names=True)
        elif path.is_symlink():
            yield Left(name, "is a link that leads elsewhere; look there", names=False)
        elif not _is_text(content):
            yield Left(name, "is no text to search; look at it", names=False)


def _place(content: bytes, tells: Callable[[bytes], str | None]) -> str | None:
    """What the first line says that tells something."""
    told = ((tells(line), n) for n, line in enumerate(content.split(b"\n"), 1))
    return next((f"{what} in line {n}" for what, n in told if what is not None), None)


def _is_text(content: bytes) -> bool:
    try:
        return "\0" not in content.decode()
    except UnicodeDecodeError:
        return False


def _left_of_others(root: Path, code: str, of_others: Collection[Path]) -> Iterator[Left]:
    """What the files of others, which stay as they are byte for byte, say of the participant: remarks, strange rows."""
    study = root / STUDY
    is_word_of_study = study in of_others and mention(_content(study), code) is not None
    for path in of_others:
        tells = None if path.name == NAME and is_word_of_study else _teller(path, code)
        place = None if tells is None else _place(_content(path), tells)
        if place is not None:
            yield Left(_name(root, path), f"names {place}", names=True)


def _teller(path: Path, code: str) -> Callable[[bytes], str | None] | None:
    """How a line of a file names the participant; None of a file where the code may be a word of the study."""
    if path.suffix == ".csv":
        return lambda line: code if line.startswith(f"{code},".encode()) else None
    if path.suffix == ".jsonl":
        return lambda line: mention(line, code) if line.startswith(b'{"event":') else None
    if path.name.endswith("_events.tsv") or path.name == NAME:
        return lambda line: mention(line, code)
    return None


def _unsearched(root: Path, code: str) -> Iterator[Left]:
    """Hidden folders, and data sets of their own within the folder that hold the participant too."""
    for folder, folders, _ in os.walk(root):
        within = [
            Path(folder) / name for name in folders if not name.startswith(".") and _is_a_set(Path(folder) / name)
        ]
        hidden = [Path(folder) / name for name in sorted(folders) if name.startswith(".")]
        yield from (
            Left(_name(root, path), "is hidden and was not searched; look there", names=False) for path in hidden
        )
        folders[:] = [name for name in folders if Path(folder) / name not in (*hidden, *within)]
        for other in within:
            if any(is_named_for(path.name, code) for path in other.rglob("*")):
                yield Left(_name(root, other), f"is a data set of its own; tactometry erase {other} too", names=True)
