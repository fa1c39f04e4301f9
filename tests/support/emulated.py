"""Emulated sensors in separate processes, and their libraries."""

import importlib.util
import os
import socket
import subprocess
import sys
import time
import uuid

import emulator
from patience import LONGEST_WAIT_S

from tactometry.devices.sensors.lsl import LslSettings
from tactometry.devices.sensors.reader import Reader
from tactometry.devices.sensors.serial_line import SerialSettings
from tactometry.devices.sensors.udp import UdpSettings

LIBRARIES = {"serial": "serial", "lsl": "pylsl"}


class Emulator:
    """A sensor in a separate process, and its reader."""

    def __init__(self, kind, folder, profile="1:100", options=(), name=None):
        self.kind, self.folder, self.profile, self.options = kind, folder, profile, options
        self.port = folder / "force"
        self.name = name or f"force-{uuid.uuid4().hex[:8]}"
        self.process = self.master = None
        self.udp_port = free_port()
        self.plug()
        settings = {
            "serial": SerialSettings(str(self.port), 1000.0, 3),
            "udp": UdpSettings("127.0.0.1", 1000.0, port=self.udp_port),
            "lsl": LslSettings(self.name, 1000.0, 3),
        }
        self.reader = Reader(settings[kind].source())

    def plug(self):
        target = {"serial": self.pty, "udp": lambda: str(self.udp_port), "lsl": lambda: self.name}[self.kind]()
        command = [sys.executable, emulator.__file__, self.kind, target, "--profile", self.profile, *self.options]
        passed = [self.master] if self.kind == "serial" else []
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(command, pass_fds=passed, **pipes)
        if self.kind != "serial":
            assert self.process.stdout.readline() == b"ready\n"

    def steer(self, counts, speed_um_per_s=0.0, length_um=1.0, since_s=0.0):
        self.process.stdin.write(f"{counts:.2f} {speed_um_per_s:.1f} {length_um:.1f} {since_s:.6f}\n".encode())
        self.process.stdin.flush()

    def pty(self):
        import tty

        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(os.ttyname(slave))
        os.close(slave)
        return str(self.master)

    def unplug(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process.stdin.close()
        if self.master is not None:
            os.close(self.master)
            self.master = None
            self.port.unlink()

    def close(self):
        self.reader.close()
        self.unplug()


def available(kind):
    library = LIBRARIES.get(kind)
    return library is None or importlib.util.find_spec(library) is not None


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        return line.getsockname()[1]


def wait_for(what, longest_s=LONGEST_WAIT_S):
    end_s = time.monotonic() + longest_s
    while not what():
        assert time.monotonic() < end_s, "it did not happen"
        time.sleep(0.01)
