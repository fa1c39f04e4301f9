"""What is plugged in: outputs that play a signal, sensors of force and of position; one driver a file.

`output`, `force_sensor` and `position_sensor` say what a driver promises, `kinds` names all drivers by the words of a
bench file. A driver imports its library when it is opened, and nothing else in the house imports one.
"""
