"""Outputs whose reconstruction filter enlarges a signal."""

import numpy as np
import pytest
from packed_bits import RATE_HZ, volts

from tactometry.devices.outputs.audio import AudioSettings
from tactometry.devices.outputs.file import FileSettings
from tactometry.devices.outputs.gain import Gain
from tactometry.devices.outputs.guarded import Guarded
from tactometry.devices.outputs.ni import NiSettings
from tactometry.devices.outputs.output import NullSettings
from tactometry.devices.outputs.packed import PackedSettings
from tactometry.errors import LimitExceeded
from tactometry.safety.limits import Limits
from tactometry.safety.load import Load

FINGER = Load("electrode", capacitance_f=1e-9, leak_resistance_ohm=1e7)
LIMITS = Limits(50.0, 60.0, current_peak_a=1.0, duty=1.0, session_s=1e9)
QUARTER_RATE = 50.0 * np.sqrt(2) * np.sin(np.pi / 2 * np.arange(4000) + np.pi / 4) * np.hanning(4000)
"""Its samples reach 50 V, and its course between them 70.7 V."""
CARD = Gain(10.0, 10.0)


@pytest.mark.parametrize(
    ("settings", "refused"),
    [
        (AudioSettings(RATE_HZ, "card"), True),
        (NiSettings(("Dev1/ao0",), RATE_HZ), True),
        (NiSettings(("Dev1/ao0",), RATE_HZ, reconstruction_filter=False), False),
        (FileSettings("folder"), False),
        (NullSettings(), False),
    ],
)
def test_guard_refuses_peaks_between_samples_of_a_filter(settings, refused):
    driver = settings.driver(CARD)
    guard = Guarded(driver, LIMITS, FINGER)
    if not refused:
        guard.check(volts(QUARTER_RATE[None]))
        return
    with pytest.raises(
        LimitExceeded, match=r"voltage_peak_v: found between two samples.*70\.71.* V, the limit is 50 V"
    ):
        guard.check(volts(QUARTER_RATE[None]))


def test_one_bit_output_has_no_peaks_between_samples(tmp_path):
    bits = np.where(np.random.default_rng(0).random((1, 500)) < 0.5, 50.0, -50.0)
    board = PackedSettings(str(tmp_path / "board"), 1, RATE_HZ).driver(Gain(50.0, 1.0))
    Guarded(board, LIMITS, FINGER).check(volts(bits))
    card = AudioSettings(RATE_HZ, "card").driver(CARD)
    with pytest.raises(LimitExceeded, match="between two samples"):
        Guarded(card, LIMITS, FINGER).check(volts(bits))
