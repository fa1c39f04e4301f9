"""Date, author and allowed age of a calibration."""

from datetime import date
from typing import Annotated

from annotated_types import Ge

from ..arguments.constraints import constrained
from ..arguments.require import Unlimited
from ..errors import DeviceFailed

MaxAge = Annotated[int, Ge(0)] | Unlimited


@constrained
class Measured:
    """Date, author and largest allowed age (days) of a calibration."""

    measured_on: date | None
    measured_by: str | None
    max_age_days: MaxAge | None

    def check_age(self, what: str, today: date) -> None:
        """Raise `DeviceFailed` if a calibration is too old or has no date.

        >>> from .outputs.gain import Gain
        >>> Gain(1.0, 1.0, date(2026, 1, 2), "ZG", max_age_days=90).check_age("output.gain", date(2026, 3, 1))
        >>> Gain(1.0, 1.0, date(2026, 1, 2), "ZG", max_age_days=30).check_age("output.gain", date(2026, 3, 1))
        Traceback (most recent call last):
        tactometry.errors.DeviceFailed: output.gain: found a calibration of 2026-01-02, 58 days old, expected at most \
30; repeat it with: tactometry calibrate; nothing was played
        """
        if self.max_age_days is None or isinstance(self.max_age_days, Unlimited):
            return
        if self.measured_on is None:
            raise DeviceFailed(
                f"{what}: found max_age_days without measured_on, expected the date of the calibration; nothing was "
                "played"
            )
        age_days = (today - self.measured_on).days
        if age_days < 0:
            raise DeviceFailed(
                f"{what}: found a calibration of {self.measured_on}, which is in the future, expected a date up to "
                f"{today}; correct the bench file or the clock of this computer; nothing was played"
            )
        if age_days > self.max_age_days:
            days = "day" if age_days == 1 else "days"
            raise DeviceFailed(
                f"{what}: found a calibration of {self.measured_on}, {age_days} {days} old, expected at most "
                f"{self.max_age_days}; repeat it with: tactometry calibrate; nothing was played"
            )
