"""Whatever answers the requests of a protocol: a bench with a window, a terminal, a simulated participant.

`bench` and `window` face a person, `console` a terminal, `simulated` an observer. Only here is a clock read and an
output played; `tactometry.session.run` puts the requests.
"""
