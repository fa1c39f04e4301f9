"""Table 4.3: amplitude, resolution in time and space, and contrast of the four driving signals."""

from ..reproduction import Number, Reproduction
from .four_signals import ASSUMES, measured


def numbers() -> list[Number]:
    largest = max(signal.amplitude_m for signal in measured().values())
    return [
        number
        for name, signal in measured().items()
        for number in (
            Number("amplitude", name, 1e6 * signal.amplitude_m, "um", "calibrated"),
            Number("of the largest", name, 100 * signal.amplitude_m / largest, "%", "derived"),
            Number("temporal resolution", name, 1e6 * signal.temporal_width_s, "us", "derived"),
            Number("spatial resolution", name, 1e3 * signal.width_m, "mm", "derived"),
            Number("contrast", name, signal.contrast, "", "derived"),
        )
    ]


TABLE = Reproduction(
    title="Performance of the four driving signals",
    stated="That there is such a table (page 16); of its values only the ranking is in our sources: finding-5.",
    assumes=f"{ASSUMES} The moment per volt of a patch was set so that one bit gives about 10 um. Resolutions "
    "are full widths at half of the amplitude (of the envelope in time); contrast is the amplitude over the rms "
    "of the plate.",
    numbers=numbers,
)
