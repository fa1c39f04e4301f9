"""What reached a participant before a sitting, by the journals of the data set."""

import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Final

import msgspec

from ..files.durable import read_file
from ..safety.limits import Exposure
from ..session.event import Event, decode_event

_STIMULUS: Final = b'{"event":"stimulus"'


def stimuli(journal: Path) -> Iterator[Event]:
    """The stimuli of a journal, by a quick look: a damaged line is none."""
    for line in read_file(journal, "a journal").split(b"\n"):
        if line.startswith(_STIMULUS):
            try:
                yield decode_event(msgspec.json.decode(line))
            except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
                continue


def exposure_before(own: Path, others: list[Path], elapsed_s: float, window_s: float) -> Exposure:
    """What counts when a session goes on, or another of the same participant begins, on `time.perf_counter`.

    Stimuli of the last `window_s` of all journals; the time (`elapsed_s`) and the charge of the session's `own`. A
    stimulus that was stopped counts as long as it was to be. One that is yet to come by the wall clock, which was set
    back, has just begun.
    """
    # the wall clock is what sittings share: `perf_counter` begins somewhere else in each
    now_s, now_utc_s = time.perf_counter(), time.time()
    of_session = list(stimuli(own))
    of_others = [event for journal in others for event in stimuli(journal)]
    intervals_s = []
    for event in (*of_session, *of_others):
        utc_s = _utc_s(event)
        if utc_s is None or event.duration_s is None:
            continue
        since_s = min(utc_s - now_utc_s, 0.0)
        if since_s > -window_s - event.duration_s:
            begin_s = now_s + since_s
            intervals_s.append((begin_s, begin_s + event.duration_s))
    charges_c = [charge for event in of_session if isinstance(charge := event.facts.get("charge_c"), float)]
    return Exposure(now_s - elapsed_s, tuple(sorted(intervals_s)), sum(charges_c))


def _utc_s(event: Event) -> float | None:
    try:
        return None if event.timestamp_utc is None else datetime.fromisoformat(event.timestamp_utc).timestamp()
    except (ValueError, OverflowError):
        return None
