"""The packages of the wheel: those of the kernel, and each room of the repository as `tactometry.ROOM`."""

from setuptools import find_packages, setup

ROOMS = ("stimuli", "protocols", "analysis", "experiments")


def packages_of(folder: str, name: str, without: tuple[str, ...] = ()) -> list[str]:
    inner = find_packages(folder, exclude=[pattern for room in without for pattern in (room, f"{room}.*")])
    return [name, *(f"{name}.{package}" for package in inner)]


setup(
    packages=[
        *packages_of("tactometry", "tactometry", without=ROOMS),
        *(package for room in ROOMS for package in packages_of(room, f"tactometry.{room}")),
    ]
)
