"""When a calibration was measured, by whom, and how long it holds."""

from dataclasses import dataclass
from datetime import date

from ..arguments.require import whole
from ..errors import DeviceFailed


@dataclass(frozen=True)
class Measured:
    """Date and author of a calibration, and the age (days) up to which it is used; None is no limit."""

    on: date | None = None
    by: str | None = None
    max_age_days: int | None = None

    def check(self, what: str, today: date) -> None:
        """Refuse a calibration that is older than allowed, or of unknown age where one is asked for.

        Raises
        ------
        DeviceFailed
            In one sentence that opens with `what`.

        Examples
        --------
        >>> Measured(date(2026, 1, 2), "ZG", max_age_days=90).check("output.gain", date(2026, 3, 1))
        >>> Measured(date(2026, 1, 2), "ZG", max_age_days=30).check("output.gain", date(2026, 3, 1))
        Traceback (most recent call last):
        tactometry.errors.DeviceFailed: output.gain: found a calibration of 2026-01-02, 58 days old, expected at most \
30; measure it again with: tactometry calibrate; nothing was played
        """
        if self.max_age_days is None:
            return
        if self.on is None:
            raise DeviceFailed(
                f"{what}: found max_age_days without measured_on, expected the date of the calibration; nothing was "
                "played"
            )
        age_days = (today - self.on).days
        if age_days < 0:
            raise DeviceFailed(
                f"{what}: found a calibration of {self.on}, which is yet to come, expected a day up to {today}; "
                "correct the bench file, or the clock of this computer; nothing was played"
            )
        if age_days > self.max_age_days:
            days = "day" if age_days == 1 else "days"
            raise DeviceFailed(
                f"{what}: found a calibration of {self.on}, {age_days} {days} old, expected at most "
                f"{self.max_age_days}; measure it again with: tactometry calibrate; nothing was played"
            )


def check_age(owner: str, max_age_days: int | None) -> None:
    """Refuse an age that is none.

    Raises
    ------
    InvalidParameter
        If it is neither None nor a whole number of at least 0; the sentence names `owner`.
    """
    if max_age_days is not None:
        whole(owner, lowest=0, max_age_days=max_age_days)
