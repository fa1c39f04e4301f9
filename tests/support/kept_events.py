"""A log that keeps the events of a rig for a test to read."""


class Kept:
    """Events in a list."""

    recorded_s = None

    def __init__(self):
        self.events = []

    def note(self, event):
        self.events.append(event)

    def keep_path(self, digest, lines):
        """No texture is followed here."""

    @property
    def told(self):
        return [(event.kind, event.facts.get("text")) for event in self.events]
