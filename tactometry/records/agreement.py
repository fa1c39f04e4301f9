"""Whether a file that is derived from a journal says what the journal says."""

from ..errors import count_of

REBUILD = "write it anew with tactometry rebuild"


def is_beginning(existing: bytes, expected: bytes) -> bool:
    """Whether a file is what a crash may leave of the expected one: its beginning, with zero bytes behind it.

    >>> is_beginning(b"a\\n1", b"a\\n12\\n"), is_beginning(b"a\\n2\\n", b"a\\n1\\n2\\n")
    (True, False)
    """
    return expected.startswith(existing.rstrip(b"\0"))


def first_difference(existing: bytes, expected: bytes) -> int | None:
    """The first line, from 1, in which two files differ; None if they are equal."""
    if existing == expected:
        return None
    pairs = zip(existing.split(b"\n"), expected.split(b"\n"), strict=False)
    differing = next((n for n, (a, b) in enumerate(pairs, 1) if a != b), None)
    # the lines of the shorter one are all equal: the first that it lacks
    return differing if differing is not None else min(existing.count(b"\n"), expected.count(b"\n")) + 1


def disagreement(existing: bytes, expected: bytes) -> tuple[int, str] | None:
    """The first line, from 1, in which a derived file differs from what its journal holds, and how; None if equal.

    >>> disagreement(b"a\\n1\\n", b"a\\n1\\n2\\n3\\n")
    (3, 'lacks the last 2 rows of the journal, expected all of them; write it anew with tactometry rebuild')
    """
    row = first_difference(existing, expected)
    if row is None:
        return None
    if not is_beginning(existing, expected):
        return row, f"found another row than the journal holds, expected the same; move the file away, then {REBUILD}"
    n_lacking = expected.count(b"\n") - existing.count(b"\n")
    if n_lacking == 0:
        return row, f"found zero bytes behind the last row, expected none; {REBUILD}"
    return row, f"lacks the last {count_of(n_lacking, 'row')} of the journal, expected all of them; {REBUILD}"
