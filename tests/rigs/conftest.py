"""What the tests of rigs have in common."""

from experimenter_seat import bench_with, kept, terminal

__all__ = ["bench_with", "kept", "terminal"]
