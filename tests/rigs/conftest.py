"""Shared fixtures of the rig tests."""

from experimenter_seat import bench_with, kept, terminal

__all__ = ["bench_with", "kept", "terminal"]
