"""Whatever answers the requests of a protocol: a bench with a window, a terminal, a simulated participant, a recording.

`bench` and `window` face a person, `console` a terminal, `simulated` an observer, `replay` an earlier session. Only
here is a clock read and an output played; `tactometry.session.run` puts the requests.
"""
