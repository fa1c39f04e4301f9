"""`tactometry watch`."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import click

from ..arguments.require import expect
from ..errors import DeviceFailed, InvalidFile
from .output import data_argument, say, subcommand

NICENESS = 10
OR_WAIT = "or --wait to wait for it"


@subcommand("watch pilot")
@data_argument
@click.option("--participant", help="Participant; default: the participant of the newest session.")
@click.option(
    "--session", "n_session", type=click.IntRange(1), help="Session of the participant; default: the newest session."
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port on this computer; default: any free one.")
@click.option("--wait", is_flag=True, help="Wait until PATH exists.")
@click.option("--until-input-ends", is_flag=True, help="End when the standard input is closed.")
def command(
    *, path: Path, participant: str | None, n_session: int | None, port: int, wait: bool, until_input_ends: bool
) -> None:
    """Serve a page that follows a running session of the data set PATH.

    It shows progress, levels, curve, touches, frames and warnings. It is read-only and available on this computer only.
    Press Ctrl-C to end it.
    """
    from tactometry.experiments.watch.scenery import Scenery
    from tactometry.experiments.watch.server import serve
    from tactometry.experiments.watch.watcher import Watcher

    expect(wait or path.is_dir(), path, "no folder", f"a data set, {OR_WAIT}", InvalidFile)
    watcher = Watcher(path, participant, n_session)
    expect(
        wait or watcher.finds, path, "no journal of this session", f"a session that has begun, {OR_WAIT}", InvalidFile
    )
    with suppress(AttributeError, OSError):  # not available everywhere; a lower priority leaves the CPU to the session
        os.nice(NICENESS)
    serve(Scenery(watcher), port, lambda url: say(url, {"url": url}), sys.stdin.buffer if until_input_ends else None)


@contextmanager
def watching(root: Path, participant: str, n_session: int) -> Iterator[str]:
    """Serve a page that follows a session during the body.

    Raises `DeviceFailed` if the page cannot be served.
    """
    session = ["--participant", participant, "--session", str(n_session)]
    command = [sys.executable, "-m", "tactometry", "watch", str(root), *session, "--wait", "--until-input-ends"]
    # a separate process group, as Ctrl-C is for the followed session
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as page:
        assert page.stdout is not None
        url = page.stdout.readline().strip()
        if not url:
            _, errors = page.communicate()
            raise DeviceFailed(f"--watch: found no page ({' '.join(errors.split())}), expected a page; omit the option")
        try:
            yield url
        finally:
            page.communicate()  # the page ends when its input is closed
