"""A display of its own for the tests that need one, and hands that press its keys and touch it."""

import gc
import os
import queue
import secrets
import shutil
import threading
import time
import zlib
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from calibrating import calibrate
from compile_once import compile_once
from force_bench import needed
from hands import SCREEN_PX, Hands
from hard_cases import only_hard_cases, pytest_addoption, pytest_sessionfinish
from hypothesis import settings
from patience import LONGEST_WAIT_S
from sampled import Passing
from scratch import write_in_memory
from soak import SOAK
from sound_server import alsa, portaudio, server, sink

from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.output import Driver
from tactometry.safety.limits import Limits

__all__ = ["alsa", "calibrate", "needed", "portaudio", "pytest_addoption", "pytest_sessionfinish"]
__all__ += ["server", "sink"]

SEED = secrets.randbits(32) if SOAK else int(os.environ.get("TACTOMETRY_TEST_SEED", "0"))
settings.register_profile("reduced", deadline=None, max_examples=100, derandomize=True)
settings.register_profile("once", settings.get_profile("reduced"), max_examples=25)
settings.register_profile("soak", deadline=None, max_examples=1000)
settings.load_profile("soak" if SOAK else "reduced")
write_in_memory()
compile_once()

# Every core has a process of its own: threads of linear algebra would wait for each other by spinning, at four times
# the processor time. Read when numpy is first loaded: by the processes that pytest starts, and by their programs.
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


@pytest.fixture(autouse=True)
def own_state(tmp_path_factory, monkeypatch):
    """No output of a test counts what the outputs of another test played."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path_factory.getbasetemp() / secrets.token_hex(8)))


TESTS = Path(__file__).resolve().parent
ARTEFACTS = TESTS.parent / "artefacts"
KEPT = []
"""The connection that keeps the server up lives as long as this process."""


FOLDERS = ("devices", "rigs", "whole", "experiments", "analysis", "stimuli", "protocols", "kernel")
"""What waits and what takes long comes first, of several processes; what is short fills the end."""


def group_of(item):
    return "display" if "display" in item.fixturenames else item.path.name


def place_of(item):
    """The display comes before all: one process has it for half of the time."""
    if group_of(item) == "display":
        return -1
    return next((place for place, folder in enumerate(FOLDERS) if TESTS / folder in item.path.parents), 0)


def pytest_xdist_auto_num_workers():
    """Two more than the cores: the process that has the display waits for more than half of its time, and those of the
    devices for a third."""
    return (os.cpu_count() or 1) + 2


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is collected stays until the end: no collection of garbage goes through it, then or later."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()
        gc.set_threshold(5000, 20, 20)  # seldom: what a test makes goes mostly without it


def pytest_report_header():
    return f"draws: TACTOMETRY_TEST_SEED={SEED}"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Of several processes one has the display; each other file stays whole, as its tests share what it sets up.

    First of these hooks, since that of the processes writes the groups into the names of the tests.
    """
    for item in items:
        item.add_marker(pytest.mark.xdist_group(group_of(item)))
        if item.get_closest_marker("soak") and not SOAK:
            item.add_marker(pytest.mark.skip(reason="full size: make soak"))
    if hasattr(config, "workerinput"):
        items.sort(key=place_of)
    if config.getoption("--stability"):
        items[:] = only_hard_cases(items)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item, nextitem):
    """A generator without a seed draws by the test's name, so that a failure can be seen again; another
    `TACTOMETRY_TEST_SEED` gives other draws, and each run at full size takes new ones."""
    del nextitem
    seeds = np.random.SeedSequence([zlib.crc32(item.nodeid.removesuffix(f"@{group_of(item)}").encode()), SEED])
    make = np.random.default_rng
    np.random.default_rng = lambda seed=None: make(seeds.spawn(1)[0] if seed is None else seed)
    try:
        return (yield)
    finally:
        np.random.default_rng = make


@pytest.fixture(scope="session")
def display(tmp_path_factory):
    """A 24-bit X server that ends with its last client, and with this process at the latest.

    It must not be ended earlier: a client whose server goes takes the whole process with it. This connection
    is its first client and keeps it from ending between two windows.
    """
    if find_spec("psychopy") is None:
        pytest.skip("no psychopy: pip install 'tactometry[window]'")
    missing = [name for name in ("Xvfb", "setpriv") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"no {' and no '.join(missing)}: apt-get install xvfb util-linux")
    read_end, write_end = os.pipe()
    size = "{}x{}x24".format(*SCREEN_PX)
    command = ["setpriv", "--pdeathsig", "KILL", "Xvfb", "-displayfd", str(write_end), "-screen", "0", size]
    os.set_inheritable(write_end, True)
    silent = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)]
    os.posix_spawnp("setpriv", [*command, "-terminate", "-nolisten", "tcp"], os.environ, file_actions=silent)
    os.close(write_end)
    with os.fdopen(read_end) as answer:
        number = answer.readline().strip()
    assert number, "Xvfb did not start"
    os.environ["DISPLAY"] = f":{number}"
    os.environ["HOME"] = str(tmp_path_factory.mktemp("home"))
    KEPT.append(Hands(f":{number}"))
    return KEPT[-1]


@pytest.fixture
def hands(display):
    return display


@pytest.fixture(scope="session")
def screen(display):
    """The one window of all tests in this process."""
    from tactometry.rigs.window import Window

    return Window(fullscreen=False, size=SCREEN_PX)


@pytest.fixture(scope="session")
def artefacts():
    ARTEFACTS.mkdir(exist_ok=True)
    return ARTEFACTS


@pytest.fixture
def in_background():
    """Runs functions in threads, and lets their errors fail the test."""
    threads, errors = [], []

    def start(work, *args):
        def guarded():
            try:
                work(*args)
            except BaseException as error:
                errors.append(error)

        threads.append(threading.Thread(target=guarded, daemon=True))
        threads[-1].start()

    yield start
    for thread in threads:
        thread.join(LONGEST_WAIT_S)
        assert not thread.is_alive(), "a thread of the test did not end"
    if errors:
        raise errors[0]


class Watched(Passing):
    """A window that tells a thread when a page is shown, and notes when it would be closed."""

    def __init__(self, window, log):
        super().__init__(window)
        self._log = log
        self.shown = queue.Queue()
        self.pages, self.drawn = [], []

    def present(self, page):
        flipped_s = self.wrapped.present(page)
        self.pages.append(page)
        self.shown.put(flipped_s)
        return flipped_s

    def refresh(self, page):
        self.drawn.append(page)
        return self.wrapped.refresh(page)

    def close(self):
        self._log.append("screen.close")


class LoggedDriver(Driver):
    """A driver whose calls are logged in a list."""

    name, n_channels, rate_hz, full_scale_v, connected = "list", 1, 20_000.0, 50.0, False

    def __init__(self, log):
        self._log = log

    def final(self, signal):
        return signal

    def open(self):
        self._log.append("output.open")

    def play(self, signal):
        self._log.append(f"play {signal.peak:.3g} V")
        return time.perf_counter()

    def stop(self):
        self._log.append("output.stop")

    def close(self):
        self._log.append("output.close")


@pytest.fixture
def log():
    return []


@pytest.fixture
def watched(screen, log, monkeypatch):
    monkeypatch.setattr("tactometry.rigs.experimenter.supervisor.STOPPED_S", 0.05)
    screen.events()
    return Watched(screen, log)


@pytest.fixture
def output(log):
    return Guarded(LoggedDriver(log), Limits(voltage_peak_v=50.0))


class Participant:
    """Acts in the background once a page is shown: taps a key (str), touches a place (x, y), pauses (seconds), waits
    until something is seen (Event), does what is called."""

    def __init__(self, watched, hands, in_background):
        self._watched, self._hands, self._in_background = watched, hands, in_background

    def answers(self, *acts):
        self._in_background(self._act, acts)

    def answers_each_page(self, *keys, hold_s=0.0):
        self._in_background(self._tap_each, keys, hold_s)

    def _act(self, acts):
        self._watched.shown.get(timeout=LONGEST_WAIT_S)
        for act in acts:
            match act:
                case str():
                    self._hands.tap(act)
                case (x, y):
                    self._hands.touch(x, y)
                case threading.Event():
                    assert act.wait(LONGEST_WAIT_S), "what the participant waits for was not seen"
                case _ if callable(act):
                    act()
                case _:
                    time.sleep(act)

    def _tap_each(self, keys, hold_s):
        for key in keys:
            self._watched.shown.get(timeout=LONGEST_WAIT_S)
            self._hands.tap(key, hold_s)


@pytest.fixture
def participant(watched, hands, in_background):
    return Participant(watched, hands, in_background)


@pytest.fixture
def unhurried_sensors(monkeypatch):
    """Where silence is not the subject: a busy machine may hold up a sensor's thread for longer than it is borne."""
    for name in ("gated_samples.SILENT_S", "watchdog.SILENT_S", "gated_samples.DEAF_S"):
        monkeypatch.setattr(f"tactometry.rigs.touch.{name}", LONGEST_WAIT_S)


@pytest.fixture
def synced(monkeypatch):
    """The paths that are synced to the disk, in order; the disk is synced all the same."""
    paths, fsync = [], os.fsync

    def noted(file):
        paths.append(Path(f"/proc/self/fd/{file}").readlink())
        fsync(file)

    monkeypatch.setattr(os, "fsync", noted)
    return paths


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A recorded session of the tutorial that no test changes."""
    from tutorial_session import live

    root = tmp_path_factory.mktemp("whole") / "d"
    live(root)
    return root


@pytest.fixture
def lived(whole, tmp_path):
    """A copy of it to spoil."""
    return Path(shutil.copytree(whole, tmp_path / "d"))


@dataclass
class GrowingJournal:
    """A journal that contains as many of a session's lines as requested."""

    path: Path
    lines: list

    @property
    def root(self):
        return self.path.parents[1]

    def holds(self, n_lines=None, more=b""):
        """Write the first lines, or all, and any text after them."""
        self.path.write_bytes(b"".join(self.lines[:n_lines]) + more)


@pytest.fixture
def journal(whole, tmp_path):
    (tmp_path / "journals").mkdir()
    (tmp_path / "study.toml").write_bytes((whole / "study.toml").read_bytes())
    [recorded] = (whole / "journals").glob("*.jsonl")
    return GrowingJournal(tmp_path / "journals" / recorded.name, recorded.read_bytes().splitlines(keepends=True))
