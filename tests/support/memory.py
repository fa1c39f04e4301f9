"""An in-memory recorder of requests and answers."""

from tactometry.session.replay import Replay


class Memory:
    """Keeps what the loop gives it; starts with `entries` of an earlier sitting."""

    def __init__(self, entries=()):
        self.earlier = list(entries)
        self.entries = list(entries)
        self.finished = False

    @property
    def replay(self):
        return Replay(self.earlier, "memory")

    def append(self, request, answer):
        self.entries.append((request, answer))

    def finish(self):
        self.finished = True

    @property
    def trials(self):
        return [request.trial for request, _ in self.entries if type(request).__name__ == "Record"]
