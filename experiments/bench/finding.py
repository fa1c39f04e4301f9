"""One thing that a preflight looked at, and what all of them together come to."""

from collections.abc import Iterator
from dataclasses import dataclass

from tactometry.errors import TactometryError


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at; `fine` is None where there is nothing to judge."""

    part: str
    what: str
    found: str
    expected: str = ""
    fine: bool | None = None
    device: bool = False


def duration(part: str, what: str, measured_s: float, longest_s: float) -> Finding:
    """A time that must not be longer."""
    words = f"{1e3 * measured_s:.1f} ms", f"at most {1e3 * longest_s:g} ms"
    return Finding(part, what, *words, fine=measured_s <= longest_s)


def exit_status(findings: list[Finding]) -> int:
    """3 if a device failed, 1 if something else is not fine, else 0.

    >>> exit_status([Finding("disk", "free", "1 GB", fine=True), Finding("display", "", "", fine=False, device=True)])
    3
    """
    if any(finding.fine is False and finding.device for finding in findings):
        return 3
    return int(any(finding.fine is False for finding in findings))


def findings_of(part: str, findings: Iterator[Finding]) -> Iterator[Finding]:
    """The findings of a part, as it is looked at; a failure is one more, and those before it stay."""
    try:
        yield from findings
    except TactometryError as error:
        yield Finding(part, "failed", str(error), fine=False, device=error.exit_status == 3)
