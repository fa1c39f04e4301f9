"""The figures of a report. matplotlib is used here and in `style` only."""
