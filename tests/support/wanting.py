"""A simulated participant with an experimenter who intervenes."""

from dataclasses import replace

from tactometry.session.answer import Done, Intervention
from tactometry.session.event import Event, order_facts
from tactometry.session.request import Intervene, Record, Show


class Wanting:
    """A rig with interventions at given numbers of rows or pages (`at`).

    ``back`` (or ``back 2``) takes back the row that was recorded so many rows before. A `log` has the orders as events,
    and what was wanted in an earlier sitting; the session is interrupted before the request number `stops_at`, or
    (`stops_late`) as it is answered.
    """

    def __init__(self, rig, at, log=None, stops_at=None, *, stops_late=False):
        self._rig, self._at, self._log = rig, dict(at), log
        self._stops_at, self._stops_late, self._n, self._pending = stops_at, stops_late, 0, ()
        self.recorded, self.said = [], []

    def answer(self, request):
        self._n += 1
        if self._n == self._stops_at and not self._stops_late:
            raise KeyboardInterrupt
        answer = self._answer(request)
        if self._n == self._stops_at:
            raise KeyboardInterrupt
        return answer

    def _answer(self, request):
        if isinstance(request, Intervene):
            self.said.append(request.said)
            return Done(self._rig._now_s)
        answer = self._rig.answer(request)
        if isinstance(request, Record):
            self.recorded.append(request.trial)
            return self._with(answer, len(self.recorded))
        return self._with(answer, request.message) if isinstance(request, Show) else answer

    def _with(self, answer, when):
        wanted = tuple(self._intervention(words) for words in self._at.pop(when, "").split(", ") if words)
        for each in wanted:
            if self._log is not None:
                self._log.note(Event("order", answer.at_s, None, order_facts(each)))
        wanted, self._pending = (*self._pending, *wanted), ()
        return replace(answer, interventions=wanted)

    def _intervention(self, words):
        word, _, n = words.partition(" ")
        if word != "back":
            return Intervention(word)
        return Intervention("invalidate", self.recorded[-int(n or 1)].key)

    def resume(self, trials, elapsed_s):
        self.recorded, self._pending = list(trials), self._log.wanted
        self._rig.resume(trials, elapsed_s)

    def __getattr__(self, name):
        return getattr(self._rig, name)
