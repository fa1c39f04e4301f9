"""Answers at once, and always the same."""

from collections.abc import Sequence

from ..session.answer import Adjusted, Chosen, Done, Filled, Played, Rated, Touched
from ..session.request import Adjust, Choose, Enter, Facts, Fill, Play, Press, Record, Show, Slide, Wait
from ..session.run import LiveRig
from ..trials.trial import Trial


class Hurried(LiveRig):
    """Chooses the first option and the low end; nothing is played, and no time passes."""

    def facts(self) -> Facts:
        return {"rig": "hurried"}

    def resume(self, trials: Sequence[Trial], elapsed_s: float) -> None:
        pass

    def close(self) -> None:
        pass

    def _play(self, request: Play) -> Played:
        return Played(0.0, None, "")

    def _feel(self, request: Press | Slide) -> Touched:
        return Touched(0.0, None, None)

    def _choose(self, request: Choose) -> Chosen:
        return Chosen(request.options[0], 0.0, 0.0)

    def _enter(self, request: Enter) -> Rated:
        return Rated(request.low, 0.0, 0.0)

    def _fill(self, request: Fill) -> Filled:
        return Filled((request.low,) * len(request.questions), 0.0, 0.0)

    def _adjust(self, request: Adjust) -> Adjusted:
        return Adjusted(request.start, 0.0, 0.0)

    def _wait(self, request: Wait) -> Done:
        return Done(0.0)

    def _show(self, request: Show) -> Done:
        return Done(0.0)

    def _record(self, request: Record) -> Done:
        return Done(0.0)
