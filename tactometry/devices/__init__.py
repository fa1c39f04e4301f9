"""Devices: outputs that play a signal, sensors of force and position; one driver per file.

`outputs.output` and `sensors.reader` define what a driver promises; `kinds` lists all by their bench-file names. A
driver imports its library when it is opened.
"""
