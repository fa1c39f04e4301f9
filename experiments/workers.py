"""Run calls in this process, on local processes or on a Dask cluster."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, TypeVar

from tactometry.arguments.require import expect
from tactometry.errors import DeviceFailed

T = TypeVar("T")
R = TypeVar("R")


class Spread(Protocol):
    """Function that calls another with each item, and yields ordered results."""

    def __call__(self, function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]: ...


def here(function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
    """Yield results computed in this process, each when it is requested."""
    return map(function, items)


def check_workers(n_jobs: int, scheduler: str | None) -> None:
    """Reject an invalid number of processes, or a number with a cluster.

    Raises `InvalidParameter` if the number is neither -1 nor at least 1, or a cluster is stated too.
    """
    is_number = n_jobs == 1 if scheduler else n_jobs >= 1 or n_jobs == -1
    expected = "--scheduler alone" if scheduler else "at least 1, or -1 for all cores"
    expect(is_number, "--jobs", n_jobs, expected)


@contextmanager
def workers(n_jobs: int = 1, scheduler: str | None = None) -> Iterator[Spread]:
    """Return a function that distributes calls over processes or a cluster.

    `n_jobs` is the number of local processes (-1: one for each core), `scheduler` the address of a Dask cluster.

    Raises `DeviceFailed` if the cluster does not respond, or its package is not installed.

    >>> with workers() as spread:
    ...     list(spread(abs, [-1, 2]))
    [1, 2]
    """
    if scheduler is not None:
        with _cluster(scheduler):
            yield _parallel(-1)
    elif n_jobs == 1:
        yield here
    else:
        yield _parallel(n_jobs)


def _parallel(n_jobs: int) -> Spread:
    import joblib

    def spread(function: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        results: Iterator[R] = joblib.Parallel(n_jobs=n_jobs, return_as="generator")(
            map(joblib.delayed(function), items)
        )
        return results

    return spread


@contextmanager
def _cluster(scheduler: str) -> Iterator[Any]:
    try:
        import distributed
        import joblib
    except ImportError:
        raise DeviceFailed(
            "--scheduler: the package distributed is not installed, expected the extra: pip install tactometry[cluster]"
        ) from None
    try:
        client = distributed.Client(scheduler, timeout=10)
    except (OSError, ValueError, TypeError) as error:
        raise DeviceFailed(
            f"--scheduler: no Dask scheduler responds at {scheduler!r} ({error}), expected an address such as "
            "tcp://host:8786"
        ) from None
    with client, joblib.parallel_config(backend="dask", wait_for_workers_timeout=30):
        yield client
