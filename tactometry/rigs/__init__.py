"""Rigs, which answer a protocol's requests: bench, console and simulated.

Only rigs read a clock and play outputs. `tactometry.session.run` passes the requests to them.
"""
