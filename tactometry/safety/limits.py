"""Safety limits, checked on the final samples by every rig and output."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from typing import Any, Final

from ..arguments.constraints import Positive, constrained
from ..arguments.require import Unlimited, at_most, expect
from ..errors import LimitExceeded
from ..signal import Signal
from .load import Load, filtered_peak_v
from .reconstruction import TOLERANCE

ROUNDING = 1e-12
"""Relative excess that counts as rounding."""

LONGEST_SIGNAL_S = 60.0
"""Default longest duration of a signal without a connected load, s (unverified default)."""

FORCE_PEAK_N = 10.0
"""Default limit of the finger's force, N. It is several times the force of touches in the literature, and below the
force that small force sensors and thin glass withstand (unverified default)."""

STOP_WITHIN_S: Final = 0.1
"""Default longest delay of a stop, s. A driver that cannot confirm a stop by then has failed (unverified default)."""

LONGEST_WINDOW_S: Final = 3600.0
"""Longest window of a duty, s. A longer window would allow signals without a pause for too long (unverified
default)."""

NEEDED = {
    "electrode": ("duration_s", "duty", "session_s"),
    "piezo": ("duration_s", "displacement_peak_m", "duty", "session_s"),
}
"""Limits that a connected load of each kind requires. Both kinds also require a limit of current or charge."""


@dataclass(frozen=True)
@constrained
class Limits:
    """Largest values that an output may emit. None means not stated.

    All values except `duty` and `duty_window_s` may be `UNLIMITED`. A file may state numbers up to the bound in
    `HIGHEST`.

    - `voltage_peak_v`: Peak voltage on any channel, above 0.
    - `duration_s`: Longest single signal, above 0. The default is `LONGEST_SIGNAL_S`, but a connected load requires a
      value.
    - `current_peak_a`: Highest current into the load of any channel, above 0.
    - `charge_peak_c`: Highest charge into the load of any channel, above 0.
    - `displacement_peak_m`: Peak displacement of the surface, above 0.
    - `duty`: Largest fraction of any `duty_window_s` during which signals play, above 0, at most 1.
    - `session_s`: Longest duration of a session with an output, above 0, at most 24 h in a file. It includes all
      sittings, without the breaks between them.
    - `charge_session_c`: Largest sum of the absolute charges that the signals of a session pass through the leak of a
      load, above 0. A complete signal counts with its net charge and a stopped signal with the charge emitted until
      then. A playing signal counts with the largest charge that it may pass until a stop.
    - `force_peak_n`: Force of the finger above which nothing plays, above 0.
    - `duty_window_s`: Time window of `duty`, above 0, at most 1 h.
    - `stop_within_s`: Longest worst-case delay of a stop, above 0. The default is 0.1 s.

    Raises `InvalidParameter` if a value is outside these ranges.
    """

    voltage_peak_v: Positive | Unlimited
    duration_s: Positive | Unlimited | None = None
    current_peak_a: Positive | Unlimited | None = None
    charge_peak_c: Positive | Unlimited | None = None
    displacement_peak_m: Positive | Unlimited | None = None
    duty: Positive | None = None
    duty_window_s: Positive = 60.0
    session_s: Positive | Unlimited | None = None
    force_peak_n: Positive | Unlimited = FORCE_PEAK_N
    charge_session_c: Positive | Unlimited | None = None
    stop_within_s: Positive | Unlimited | None = None

    def __post_init__(self) -> None:
        expect(self.duty is None or self.duty <= 1, "Limits.duty", self.duty, "at most 1")
        at_most("Limits.duty_window_s", self.duty_window_s, LONGEST_WINDOW_S)

    @property
    def longest_s(self) -> float:
        """Longest duration of one signal, s."""
        return LONGEST_SIGNAL_S if self.duration_s is None else self.duration_s

    @property
    def longest_stop_s(self) -> float:
        """Longest worst-case delay of a stop, s."""
        return STOP_WITHIN_S if self.stop_within_s is None else self.stop_within_s

    @property
    def switched_off(self) -> tuple[str, ...]:
        return tuple(name for name, value in vars(self).items() if isinstance(value, Unlimited))

    def check(self, signal: Signal) -> None:
        """Refuse a signal that exceeds a limit that applies without a load, too.

        Raises `LimitExceeded` if the unit is not volt, or if peak or duration is too large. A relative excess of
        1e-12 counts as rounding.
        """
        if signal.unit != "V":
            raise LimitExceeded(f"limits: found a signal in {signal.unit!r}, expected volt ('V'); nothing was played")
        _check("voltage_peak_v", "a peak of", signal.peak, self.voltage_peak_v, "V", "lower the level")
        _check("duration_s", "a signal of", signal.duration_s, self.longest_s, "s", "shorten it")

    def check_load(self, signal: Signal, load: Load, rise_s: float = math.inf) -> None:
        """Refuse a signal that exceeds a limit of the load.

        `rise_s` is the shortest time in which the finger weakens the samples from full size to nothing; infinite if it
        does not weaken them.

        Raises `LimitExceeded` if a limit is missing, cannot be computed, or is exceeded.
        """
        self.check_stated(load)
        if self.current_peak_a is not None:
            peak_a = load.current_peak_a(signal, rise_s)
            _check("current_peak_a", "a peak of", peak_a, self.current_peak_a, "A", "lower the level or the slopes")
        if self.charge_peak_c is not None:
            peak_c = load.charge_peak_c(signal, rise_s)
            _check("charge_peak_c", "a peak of", peak_c, self.charge_peak_c, "C", "lower the level or the duration")
        if self.displacement_peak_m is not None:
            peak_m = load.displacement_peak_m(signal)
            _check("displacement_peak_m", "up to", peak_m, self.displacement_peak_m, "m", "lower the level")

    def check_filtered(self, signal: Signal, load: Load | None, rise_s: float = math.inf) -> None:
        """Refuse a signal whose filtered course exceeds a limit by `TOLERANCE`."""
        peaks: dict[str, tuple[str, Callable[[float], float]]] = {
            "voltage_peak_v": ("V", lambda bound: filtered_peak_v(signal, bound))
        }
        if load is not None:
            peaks["current_peak_a"] = "A", lambda bound: load.filtered_current_a(signal, bound, rise_s)
            peaks["charge_peak_c"] = "C", lambda bound: load.filtered_charge_c(signal, bound, rise_s)
            peaks["displacement_peak_m"] = "m", lambda bound: load.filtered_displacement_m(signal, bound)
        what = "between two samples, after the reconstruction filter, a peak of"
        cure = "smooth steps and high frequencies of the signal, or lower the level"
        for name, (unit, peak) in peaks.items():
            limit = getattr(self, name)
            if limit is not None:
                _check(name, what, peak(limit * (1 + TOLERANCE)), limit, unit, cure, TOLERANCE)

    def check_stated(self, load: Load) -> None:
        """Refuse a load whose required limits are missing."""
        missing = [name for name in NEEDED[load.kind] if getattr(self, name) is None]
        if self.current_peak_a is None and self.charge_peak_c is None:
            missing.insert(0, "current_peak_a or charge_peak_c")
        if missing:
            raise LimitExceeded(
                f"limits: found no {', no '.join(missing)}, expected them for a load of kind {load.kind!r}; state them "
                "in the bench file; nothing was played"
            )
        if self.displacement_peak_m is not None and load.displacement_m_per_v is None:
            raise LimitExceeded(
                "limits.displacement_peak_m: found a limit, but no displacement_m_per_v of the load to compute it "
                "from; state it in the bench file; nothing was played"
            )

    def check_force(self, target_n: float, tolerance: float) -> None:
        """Refuse a touch whose force band exceeds the limit."""
        _check(
            "force_peak_n", "a force of up to", target_n * (1 + tolerance), self.force_peak_n, "N", "lower the target"
        )

    def check_stop(self, delay_s: float) -> None:
        """Refuse an output whose stop may take longer than the limit."""
        cure = "lower latency_s and block_s of the output, or raise the limit in the bench file"
        _check("stop_within_s", "an output that may stop after", delay_s, self.longest_stop_s, "s", cure)

    def facts(self) -> dict[str, float | str]:
        """Return the stated limits for the head of a journal.

        >>> sorted(Limits(100.0, duty=0.5).facts())
        ['limit_duty', 'limit_duty_window_s', 'limit_force_peak_n', 'limit_voltage_peak_v']
        """
        return {
            f"limit_{name}": str(value) if isinstance(value, Unlimited) else value
            for name, value in vars(self).items()
            if value is not None
        }

    def check_exposure(self, exposure: "Exposure", begin_s: float, duration_s: float, charge_c: float = 0.0) -> None:
        """Refuse a signal that exceeds duty, session time or session charge.

        `charge_c` is the largest charge that the signal may pass until a stop at any time.
        """
        if self.duty is not None:
            duty = exposure.after(begin_s, duration_s, self.duty_window_s).played_s / self.duty_window_s
            cure = exposure.cure(begin_s, duration_s, self.duty_window_s, self.duty * self.duty_window_s)
            _check("duty", "signals during", duty, self.duty, "of the time", cure)
        if self.session_s is not None:
            end_s = begin_s + duration_s - exposure.opened_s
            _check("session_s", "a session of", end_s, self.session_s, "s", "end the session")
        if self.charge_session_c is not None:
            sum_c = exposure.charge_c + exposure.playing_c + charge_c
            _check("charge_session_c", "net charges of", sum_c, self.charge_session_c, "C", "end the session")

    def tighter(self, other: "Limits") -> "Limits":
        """Return the tighter of both values for each limit.

        If only one value is stated, it applies. Duties of different windows cannot be compared, so the result has the
        longer window and the shorter playing time.

        >>> both = Limits(200.0, duration_s=1.0).tighter(Limits(100.0, current_peak_a=1e-3))
        >>> both.voltage_peak_v, both.duration_s, both.current_peak_a
        (100.0, 1.0, 0.001)
        """
        smallest: dict[str, Any] = {}
        for name in _COMPARABLE:
            stated = [value for each in (self, other) if (value := getattr(each, name)) is not None]
            smallest[name] = min(stated, default=None)
        duties = [(limits.duty, limits.duty_window_s) for limits in (self, other) if limits.duty is not None]
        if not duties:
            return replace(self, **smallest)
        longest_s = max(window_s for _, window_s in duties)
        # scaled by the ratio of windows, so that equal windows keep the exact duty
        duty = min(duty * (window_s / longest_s) for duty, window_s in duties)
        return replace(self, **smallest, duty=duty, duty_window_s=longest_s)


@dataclass(frozen=True)
class Exposure:
    """Recent emissions of an output as intervals (begin, end), s.

    Times are on the clock of `opened_s`, which is when the session would have begun without breaks. `charge_c` is the
    total charge of ended signals, `playing_c` the largest charge that the playing signal may pass.

    >>> exposure = Exposure(opened_s=0.0).after(1.0, 2.0, window_s=10.0).after(5.0, 2.0, window_s=10.0)
    >>> exposure.played_s, exposure.stopped(5.5).played_s, exposure.after(10.0, 2.0, window_s=10.0).played_s
    (4.0, 2.5, 5.0)
    """

    opened_s: float
    intervals_s: tuple[tuple[float, float], ...] = ()
    charge_c: float = 0.0
    playing_c: float = 0.0

    @property
    def played_s(self) -> float:
        return sum(end_s - begin_s for begin_s, end_s in self.intervals_s)

    def after(self, begin_s: float, duration_s: float, window_s: float, charge_c: float = 0.0) -> "Exposure":
        """Add a signal, and drop emissions before the window."""
        end_s = begin_s + duration_s
        first_s = end_s - window_s
        # a new signal ends the playing one, so that no time counts twice
        intervals_s = (*self.stopped(begin_s).intervals_s, (begin_s, end_s))
        kept_s = tuple((max(a, first_s), b) for a, b in intervals_s if b > first_s)
        return replace(self.passed(self.playing_c), intervals_s=kept_s, playing_c=charge_c)

    def with_others(self, others_s: Iterable[tuple[float, float]]) -> "Exposure":
        return replace(self, intervals_s=tuple(sorted((*self.intervals_s, *others_s))))

    def passed(self, charge_c: float) -> "Exposure":
        """Add the charge of the signal that has ended."""
        return replace(self, charge_c=self.charge_c + charge_c, playing_c=0.0)

    def cure(self, begin_s: float, duration_s: float, window_s: float, most_s: float) -> str:
        """Return when a signal that exceeds the duty may begin.

        >>> Exposure(0.0, ((0.0, 3.0), (5.0, 8.0))).cure(9.0, 2.0, window_s=10.0, most_s=5.0)
        'wait 2.0 s'
        """
        played = self.stopped(begin_s)
        to_forget_s = played.played_s + duration_s - most_s
        for a, b in played.intervals_s:  # the oldest emissions leave the window first
            if to_forget_s <= b - a:
                # the window ends with the signal; begin it late enough to exclude the excess
                wait_s = a + to_forget_s + window_s - duration_s - begin_s
                return f"wait {math.ceil(10 * wait_s) / 10:.1f} s"  # rounded up, so that the signal is accepted then
            to_forget_s -= b - a
        return "shorten the signal"

    def stopped(self, at_s: float) -> "Exposure":
        return replace(self, intervals_s=tuple((a, min(b, at_s)) for a, b in self.intervals_s if a < at_s))


_COMPARABLE = [field.name for field in fields(Limits) if field.name not in ("duty", "duty_window_s")]


def _check(name: str, what: str, value: float, limit: float, unit: str, cure: str, tolerance: float = ROUNDING) -> None:
    """Refuse a value that is above its limit, or NaN."""
    if not value <= limit * (1 + tolerance):  # not `value > limit`, which is false for NaN
        raise LimitExceeded(
            f"limits.{name}: found {what} {value:.6g} {unit}, the limit is {limit:.6g} {unit}; {cure}; "
            "nothing was played"
        )
