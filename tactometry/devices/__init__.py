"""What is plugged in: outputs that play a signal, sensors of force and of position; one driver a file.

`outputs.output` says what a driver promises, `sensors.reader` what a source does, and `kinds` names all of them by
the words of a bench file. A driver imports its library when it is opened, and nothing else in the house imports one.
"""
