"""Rigs answer the requests of a protocol: `bench` with a window, `console`, `simulated`.

Only rigs read a clock and play outputs; `tactometry.session.run` passes the requests on.
"""
