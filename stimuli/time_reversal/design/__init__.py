"""Closed forms, the design guide, which sheet of glass."""
