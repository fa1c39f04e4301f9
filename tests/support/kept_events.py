"""An event log in memory."""

from tactometry.session.answer import TracePart


class Kept:
    recorded_s = None
    wanted = ()

    def __init__(self):
        self.events, self.traces, self.marked = [], [], []

    def note(self, event):
        self.events.append(event)

    def keep_path(self, digest, lines):
        pass

    def keep_trace(self, kind, table, rate_hz):
        self.traces.append((kind, table))
        return TracePart(kind, 0, 0, "", rate_hz)

    def keep_marks(self, marked):
        self.marked.append(marked)

    @property
    def told(self):
        return [(event.kind, event.facts.get("text")) for event in self.events]
