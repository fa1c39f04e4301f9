"""Outputs that play signals, and sensors. Each driver has its own file.

`outputs.output` and `sensors.reader` define the driver interfaces. `kinds` lists all drivers by their bench-file
names. A driver imports its library when it is opened.
"""
