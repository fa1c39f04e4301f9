"""A ledger of what was played: the peak and the duration of each signal, a line each."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from ...signal import Signal
from .gain import Gain, SignalChain
from .output import UnconnectedDriver


@dataclass(frozen=True)
class LedgerSettings:
    connected: ClassVar[bool] = False
    path: str

    def driver(self, gain: Gain | None) -> "LedgerOutput":
        del gain
        return LedgerOutput(Path(self.path))

    def chain(self) -> SignalChain:
        return SignalChain(f"ledger {self.path}")


class LedgerOutput(UnconnectedDriver):
    def __init__(self, path: Path) -> None:
        self.name, self._path = f"ledger {path}", path

    def open(self) -> None:
        self._path.touch()

    def final(self, signal: Signal) -> Signal:
        return signal

    def play(self, signal: Signal) -> float:
        onset_s = time.perf_counter()
        with self._path.open("a", encoding="utf-8") as ledger:
            ledger.write(f"{signal.peak:.2f} V, {signal.duration_s:.2f} s\n")
        return onset_s
