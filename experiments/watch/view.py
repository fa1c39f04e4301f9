"""Texts, numbers and plots of the page, before rendering as HTML."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

from tactometry.analysis.wording import in_unit, level_of, number_text, plain_text, split_unit
from tactometry.errors import count_of
from tactometry.rigs.texts import reason_words
from tactometry.session.progress import AnsweredTouch, PartAhead, Progress, TrackProgress
from tactometry.trials.tasks import TASKS, YES_OR_NO
from tactometry.trials.trial import Trial

from .plots import Plot, condition_words, last_presented, levels_plot
from .watcher import Sight

MOST_PLOTS = 4
"""Largest number of interleaved tracks with a plot."""
MOST_DROPPED = 0.01
"""Share of dropped frames above which it is marked (unverified default)."""
DEVICES = ("rig", "output", "force_sensor", "position_sensor", "frame_period_s", "output_volts_per_unit", "felt")
"""Keys of a head's facts that describe the devices of a session."""
DELAYS = {"gate_delay_s": "From gate to decision", "key_to_record_s": "From key to disk"}


class Named(NamedTuple):
    """Name and value. `mark` highlights them for the experimenter."""

    name: str
    value: str
    mark: bool = False


def minutes(lasting_s: float) -> str:
    """
    >>> minutes(30.0), minutes(600.0), minutes(7300.0)
    ('at most 1 min', 'at most 10 min', 'at most 2 h 2 min')
    """
    hours, rest = divmod(ceil(lasting_s / 60), 60)
    return f"at most {f'{hours} h ' if hours else ''}{rest} min"


def title(sight: Sight) -> str:
    """Return the page title: participant, session and study."""
    head = sight.head
    if head is None:
        return sight.name or "no session yet"
    sitting = f", sitting {len(sight.heads)}" if len(sight.heads) > 1 else ""
    return f"{head.participant}, session {head.session}{sitting}: {head.study}"


def alerts(sight: Sight) -> list[str]:
    """Return the alerts at the top of the page."""
    progress = sight.progress
    warning = None if sight.complete else progress.warning(sight.parts)
    result = [sight.problem, f"Careful: {warning}." if warning else ""]
    if sight.state == "ended without closing":
        result.append("The session ended without closing: no process records it; continue with run --resume.")
    elif progress.paused is not None and not (sight.complete or sight.halted):
        result.append(f"Paused: {progress.paused}.")
    if sight.halted:
        result.append(f"Stopped: {' '.join(progress.stopped[-1:])}; continue with run --resume.")
    return [*filter(None, result), *(f"{text[:1].upper()}{text[1:]}." for text in progress.aborted)]


@dataclass(frozen=True)
class Share:
    """Number of counted trials, and the largest planned number."""

    name: str
    n: int
    of: int

    @property
    def words(self) -> str:
        return f"{self.n} of at most {self.of}"


def shares(sight: Sight) -> list[Share]:
    """Return the progress of the current part and of the session."""
    progress, parts = sight.progress, sight.parts
    present = parts[progress.part - 1] if 0 < progress.part <= len(parts) else PartAhead()
    here = Share("Trials of this part", progress.n_valid(progress.part), present.n_trials)
    of_all = Share("Trials of the session", progress.n_valid(), sum(part.n_trials for part in parts))
    return [share for share in (here, of_all) if share.of]


def where(sight: Sight) -> Iterator[Named]:
    """Yield the position in the session: part, condition, time left and more."""
    progress = sight.progress
    if progress.n_parts:
        yield Named("Part", f"{progress.part} of {progress.n_parts}" if progress.part else f"of {progress.n_parts}")
    named = condition_words(progress.factors)
    if named:
        yield Named("Condition", named)
    if sight.parts and not sight.complete:
        yield Named("Time left", minutes(progress.left_s(sight.parts)))
    if progress.last is not None:
        yield Named("Last trial", _last(progress.last))
    track = progress.track
    if track is not None and track.reversals:
        yield Named("Reversals", str(len(track.reversals)))
    if progress.n_catch:
        yield Named("False alarms", f"{progress.n_false_alarms} of {count_of(progress.n_catch, 'catch trial')}")
    if progress.page is not None:
        yield Named("Last page", progress.page)
    if progress.interventions:
        yield Named("Last order", progress.interventions[-1])


def unit(progress: Progress) -> str:
    """Return the unit of all levels, or an empty text if it is not unique."""
    units = {trial.level_unit for track in progress.tracks.values() for trial in track.presented[:1]}
    return units.pop() if len(units) == 1 else ""


def _last(trial: Trial) -> str:
    if trial.is_form:
        return f"{trial.procedure}, {trial.item}: {_answer(trial)}"
    level = "catch trial" if trial.level is None else in_unit(plain_text(trial.level), trial.level_unit)
    return f"number {trial.trial}, {level}: {_answer(trial)}"


def _answer(trial: Trial) -> str:
    if not trial.valid:
        return f"not valid ({'unknown reason' if trial.invalid_reason is None else reason_words(trial.invalid_reason)})"
    if TASKS[trial.task].response is YES_OR_NO and trial.response is not None:
        return TASKS[trial.task].answers[trial.response == 1]
    if trial.correct is not None:
        return "correct" if trial.correct else "wrong"
    return "no answer" if trial.response is None else plain_text(trial.response)


def level_plots(progress: Progress) -> list[Plot]:
    """Return plots of the tracks in the current block, current track first."""
    last = last_presented(progress)
    if last is None:
        return []
    tracks = {name: track for (block, name), track in progress.tracks.items() if block == last.block}
    names = sorted(tracks, key=lambda name: name != last.track)[:MOST_PLOTS]
    plots = (levels_plot(f"levels{n}", _title(tracks[name], name), tracks[name]) for n, name in enumerate(names))
    return [plot for plot in plots if plot is not None]


def _title(track: TrackProgress, name: str | None) -> str:
    last = track.presented[-1]
    # A track's name repeats some factors of the condition.
    labels = [part for part in (name or "").split(", ") if part.partition("=")[0] not in last.factors]
    practice = "practice" if last.practice else ""
    return ", ".join(filter(None, (last.procedure.replace("_", " "), practice, condition_words(last.factors), *labels)))


class TouchRow(NamedTuple):
    """Table row of a touch."""

    level: str
    outcome: str
    force: str
    speed: str
    valid: bool


def touch_row(touch: AnsweredTouch) -> TouchRow:
    """Return the table row of a touch."""
    answer, level = touch.answer, touch.request.level
    reason = "not valid" if answer.invalid_reason is None else reason_words(answer.invalid_reason)
    return TouchRow(
        "blank" if level is None else plain_text(level),
        "valid" if answer.valid else reason,
        _kept(answer.force_mean_n, "N", answer.force_in_band),
        _kept(answer.speed_mean_m_per_s, "m/s", answer.speed_in_band),
        answer.valid,
    )


def _kept(mean: float | None, unit: str, in_band: float | None) -> str:
    """Return a mean, and the share of the touch within its band.

    >>> _kept(1.0123, "N", 0.954), _kept(None, "N", None)
    ('1.01 N, 95 %', '')
    """
    value = "" if mean is None else f"{number_text(mean)} {unit}"
    return ", ".join(filter(None, (value, "" if in_band is None else f"{100 * in_band:.0f} %")))


def reasons(progress: Progress) -> str:
    """Return the number of invalid touches by reason, in words."""
    if not progress.n_touches:
        return ""
    n_lost = sum(progress.reasons.values())
    by_reason = sorted(progress.reasons.items(), key=lambda item: -item[1])
    named = ", ".join(f"{n} {reason_words(reason)}" for reason, n in by_reason)
    of = f"{progress.n_touches} touch{'es' if progress.n_touches > 1 else ''}"
    return f"{n_lost} of {of} not valid{f': {named}' if named else ''}."


def quality(progress: Progress) -> Iterator[Named]:
    """Yield the quality of the screen, the output and the sensors."""
    if progress.n_frames:
        n_due = progress.n_frames + progress.n_dropped_frames
        share = progress.n_dropped_frames / n_due
        value = f"{progress.n_dropped_frames} of {n_due} that were due ({100 * share:.2g} %)"
        yield Named("Dropped frames", value, share > MOST_DROPPED)
    yield Named("Gaps in the output", str(progress.n_gaps), progress.n_gaps > 0)
    n_lost = progress.reasons.get("sensor_lost", 0)
    yield Named("Touches with a silent sensor", str(n_lost), n_lost > 0)
    for key, (last_s, longest_s) in progress.timing.items():
        yield Named(DELAYS[key], f"{_ms(last_s)}, longest {_ms(longest_s)}")
    for device, facts in progress.clocks.items():
        drift = facts.get("clock_drift")  # known from the second block on
        text = f"drift {1e6 * drift:.3g} µs/s" if isinstance(drift, int | float) else "drift not known yet"
        yield Named(f"Clock of {device}", text)


def _ms(lasting_s: float) -> str:
    """
    >>> _ms(0.0123), _ms(1.7349)
    ('12.3 ms', '1735 ms')
    """
    return f"{1e3 * lasting_s:.{1 if lasting_s < 0.1 else 0}f} ms"


def devices(sight: Sight) -> Iterator[Named]:
    """Yield the devices of the session, from its head."""
    facts = {} if sight.head is None else sight.head.facts
    for name in DEVICES:
        value = facts.get(name)
        if value is not None:
            yield Named(split_unit(name)[0], level_of(name, value))


class ConditionRow(NamedTuple):
    """Table row of a track."""

    part: int
    condition: str
    n_valid: int
    n_invalid: int
    n_reversals: str
    level: str
    state: str


def condition_rows(progress: Progress) -> list[ConditionRow]:
    """Return the table rows of all tracks, newest first."""
    last = progress.last
    present = None if last is None or last.is_form or progress.over else (last.block, last.track)
    has_one_unit = bool(unit(progress))
    rows = []
    for (block, name), track in reversed(list(progress.tracks.items())):
        shown, answered = track.presented[-1], track.answered
        n_valid = sum(trial.valid for trial in track.presented)
        labels = "practice" if shown.practice else "", condition_words(shown.factors), name or ""
        level = in_unit(plain_text(answered[-1].level), "" if has_one_unit else shown.level_unit) if answered else ""
        row = ConditionRow(
            block,
            " · ".join(filter(None, labels)),
            n_valid,
            len(track.presented) - n_valid,
            str(len(track.reversals) or ""),
            level,
            "aborted" if track.aborted else "now" if (block, name) == present else "",
        )
        rows.append(row)
    return rows
