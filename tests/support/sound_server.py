"""A real sound server with a sink that can be heard, for tests."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from emulated import wait_for

ALSA = Path("/usr/share/alsa/alsa.conf")


@pytest.fixture
def alsa(tmp_path):
    """The file over the null device takes what it gets as fast as it comes: it is large, and does not stay."""
    yield alsa_in(tmp_path)
    (tmp_path / "played.raw").unlink(missing_ok=True)


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    missing = [name for name in ("pulseaudio", "parec") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"no {' and no '.join(missing)}: apt-get install pulseaudio pulseaudio-utils libasound2-plugins")
    folder = tmp_path_factory.mktemp("sound")
    sound = Sink(folder, alsa_in(folder))
    yield sound
    sound.close()


@pytest.fixture
def sink(server):
    server.begin()
    return server


@pytest.fixture
def portaudio(sink, monkeypatch):
    """PortAudio in this process, restarted in the environment of the sink."""
    sounddevice = pytest.importorskip("sounddevice")
    for name, value in sink.env.items():
        monkeypatch.setenv(name, value)
    sounddevice._terminate()
    sounddevice._initialize()
    yield
    sounddevice._terminate()
    monkeypatch.undo()
    sounddevice._initialize()


def heard_part(frames):
    heard = np.flatnonzero(frames.any(axis=1))
    assert len(heard), "the sink heard nothing"
    return frames[heard[0] : heard[-1] + 1]


def alsa_in(folder):
    """An environment in which ALSA knows more devices: `tofile`, `pulse`, and `monitor`, what a sink hears."""
    if not ALSA.exists():
        pytest.skip("no ALSA here: apt-get install libasound2")
    devices = {
        "tofile": f'type file\nslave.pcm null\nfile "{folder}/played.raw"\nformat raw',
        "pulse": "type pulse",
        "monitor": 'type pulse\ndevice "finger.monitor"',
    }
    written = "\n".join(f"pcm.{name} {{\n{text}\n}}" for name, text in devices.items())
    (folder / "alsa.conf").write_text(f"<{ALSA}>\n{written}\npcm.!default pcm.tofile\n", encoding="utf-8")
    return {**os.environ, "ALSA_CONFIG_PATH": str(folder / "alsa.conf")}


def played(raw, wanted):
    """Return True if a recording contains the wanted frames without gaps."""
    n_channels = wanted.shape[1]
    frames = np.frombuffer(raw[: len(raw) // (2 * n_channels) * 2 * n_channels], "<i2").reshape(-1, n_channels)
    return np.array_equal(heard_part(frames), wanted)


class Sink:
    """A private PulseAudio with one silent sink, whose monitor is recorded."""

    def __init__(self, folder, alsa):
        self.env = {**alsa, "PULSE_SERVER": f"unix:{folder}/pulse.socket"}
        self.env |= {"XDG_RUNTIME_DIR": str(folder), "HOME": str(folder)}
        sink = "module-null-sink sink_name=finger rate=48000 channels=2 format=s16le"
        command = [
            "pulseaudio",
            "-n",
            "--daemonize=no",
            "--exit-idle-time=-1",
            "--use-pid-file=no",
            "--disable-shm=yes",
        ]
        loads = [f"--load={sink}", f"--load=module-native-protocol-unix socket={folder}/pulse.socket auth-anonymous=1"]
        self.server = subprocess.Popen([*command, *loads], env=self.env, stderr=subprocess.DEVNULL)
        self.raw = folder / "heard.raw"
        self.recorder = None
        try:
            wait_for((folder / "pulse.socket").is_socket)
            form = ["--format=s16le", "--rate=48000", "--channels=2", "--raw", "--latency-msec=20"]
            with self.raw.open("wb") as file:
                self.recorder = subprocess.Popen(["parec", "--device=finger.monitor", *form], env=self.env, stdout=file)
            wait_for(lambda: self.raw.stat().st_size > 0)
        except BaseException:
            self.close()
            raise

    def begin(self):
        self.n_before = self.raw.stat().st_size // 4 * 4

    def heard(self):
        """Return how many samples since `begin` were not zero."""
        raw = self.raw.read_bytes()[self.n_before :]
        return np.count_nonzero(np.frombuffer(raw[: len(raw) // 4 * 4], "<i2"))

    def end(self):
        """Wait until the record contains what was played; return its frames."""
        n_bytes = self.raw.stat().st_size
        wait_for(lambda: self.raw.stat().st_size > n_bytes + 4 * 24_000)
        raw = self.raw.read_bytes()[self.n_before :]
        return np.frombuffer(raw[: len(raw) // 4 * 4], "<i2").reshape(-1, 2)

    def close(self):
        for process in (self.recorder, self.server):
            if process is not None:
                process.terminate()
                process.wait(10)
