"""Devices: outputs that play signals, and sensors, a driver per file.

`outputs.output` and `sensors.reader` define what a driver promises; `kinds` lists all by their bench-file names. A
driver imports its library when it is opened.
"""
