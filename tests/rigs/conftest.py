"""Shared fixtures of the rig tests."""

from experimenter_seat import bench, bench_of, bench_with, kept, terminal

__all__ = ["bench", "bench_of", "bench_with", "kept", "terminal"]
