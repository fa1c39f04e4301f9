"""A stimulus that only plays, without a condition on the finger."""

from ...session.answer import Played
from ...session.request import Play
from ...signal import Signal
from ..pages.page import Page
from .setup import TouchSetup
from .watchdog import watchdog


def play_to_end(setup: TouchSetup, request: Play, page: Page, signal: Signal | None) -> Played:
    """The answer (its onset on `time.perf_counter`): it plays under a watchdog, and begins anew after a pause."""
    presenter, emitter = setup.presenter, setup.emitter
    begin_s = presenter.present(page)
    with watchdog(setup) as look:
        while True:
            onset_s = emitter.emit(signal)
            presenter.hold(onset_s + request.duration_s, page, each_frame=look)
            look()  # what happened since the last frame counts too
            if presenter.paused_until_s < begin_s:  # no pause since it began
                break
            begin_s = presenter.present(page)
    digest = emitter.digest(signal) or ""
    return Played(onset_s, emitter.delivered(request.level), digest, emitter.n_gaps(signal))
