"""Where the finger was under a texture: the paths of a session, each under the digest that its rows have."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from tactometry.files.durable import read_file
from tactometry.provenance import digest_of
from tactometry.trials.row_rules import Defect
from tactometry.trials.trial import Trial

WHAT = "the positions of a session"


def paths_in(content: bytes) -> dict[str, bytes]:
    """The lines of each path, time and place without the digest, by that.

    >>> paths_in(b"positions_digest\\ttime_s\\tposition_m\\nab\\t0.001000\\t0.050000000\\n")
    {'ab': b'0.001000\\t0.050000000\\n'}
    """
    paths: dict[str, list[bytes]] = {}
    for line in content.splitlines()[1:]:
        digest, _, place = line.partition(b"\t")
        paths.setdefault(digest.decode("ascii", "replace"), []).append(place + b"\n")
    return {digest: b"".join(lines) for digest, lines in paths.items()}


def positions_defects(journal: Path, trials: Iterable[Trial]) -> Iterator[Defect]:
    """Whether the path of each trial that has one is there, and is the one that the texture followed."""
    wanted = dict.fromkeys(trial.positions_digest for trial in trials if trial.positions_digest is not None)
    file = journal.with_name(f"{journal.stem}_positions.tsv")
    name = f"journals/{file.name}"
    if not wanted:
        return
    if not file.is_file():
        yield Defect(name, None, f"found no such file, expected the positions of {len(wanted)} trials; restore a copy")
        return
    paths = paths_in(read_file(file, WHAT))
    for digest in wanted:
        lines = paths.get(digest)
        if lines is None or digest_of(lines) != digest:
            found = "no path" if lines is None else "another path than the one that was followed"
            yield Defect(name, None, f"found {found} under {digest}, expected it as it was kept; restore a copy")
