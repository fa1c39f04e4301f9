"""The figures of a report. Of the room, only they import matplotlib."""
