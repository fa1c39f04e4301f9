"""Figures of chapters 3 and 4 about results: most as the gallery of time reversal has them."""

from collections.abc import Callable
from typing import Any

from ..figures import focusing
from ..figures.gallery import GALLERY
from ..reproduction import Origin, Reproduction

ASSUMES = "Plate, edges, layout, tau (set to finding-2), band and drive of the gallery (unverified defaults)."
CALIBRATED = f"{ASSUMES} Amplitudes go with the moment per volt of a patch, set so that one bit gives 10 um at 30 V."
OTHERS = "that the thesis took it from others' work"


def _figure(number: str, title: str, drawing: Callable[[], Any], origin: Origin, stated: str = "") -> Reproduction:
    """A figure of which our sources have the caption, and what `stated` says."""
    said = f"The caption of Figure {number} (pages 11 to 13){f', and {stated}' if stated else ''}; not the curve."
    return Reproduction(
        title=title,
        stated=said,
        assumes=CALIBRATED if origin == "calibrated" else ASSUMES,
        drawing=drawing,
        origin=origin,
    )


def _of_gallery(number: str, name: str, title: str, origin: Origin = "derived", stated: str = "") -> Reproduction:
    return _figure(number, title, GALLERY[name], origin, stated)


FIGURE_3_4 = _figure("3.4", "Characteristic time and density of modes", focusing.modal_density, "derived")
FIGURE_3_8 = _of_gallery("3.8", "3.8-focus-map", "Focus at 0-25 kHz and a cut through it", "calibrated")
FIGURE_3_9 = _of_gallery("3.9 and 3.10", "3.9-resolution-over-bandwidth", "Resolution against bandwidth, 2 and 3 mm")
FIGURE_3_11 = _of_gallery(
    "3.11 and 3.12", "3.11-amplitude-over-bandwidth", "Amplitude with 12 and 35 mm discs", "calibrated"
)
FIGURE_3_13 = _of_gallery("3.13", "3.13-scans-per-band", "Focus for several bands", "calibrated")
FIGURE_3_14 = _of_gallery("3.14", "3.14-frequency-response", "Response at the focus to 10 kHz", "calibrated")
FIGURE_3_15 = _of_gallery("3.15", "3.15-stress-and-deflection", "Bending stress and deflection under 2 N")
FIGURE_3_16 = _of_gallery("3.16 and 4.23", "3.16-resolution-over-mean-frequency", "Resolution against mean frequency")
FIGURE_3_18 = _of_gallery("3.18 and 4.12", "3.18-amplitude-over-reversal", "Amplitude against reversal time")
FIGURE_3_19 = _figure("3.19", "A focus repeated", focusing.repeated_focus, "calibrated", OTHERS)
FIGURE_3_20 = _figure(
    "3.20", "The time constants, and what a short repetition costs", focusing.time_constants, "calibrated"
)
FIGURE_3_21 = _of_gallery(
    "3.21 and 4.14", "3.21-contrast", "Contrast by transducers and reversal time", stated=f"of the first {OTHERS}"
)
FIGURE_4_9 = _of_gallery("4.9", "4.9-modulator-noise", "Quantisation noise of the modulators")
FIGURE_4_11 = _of_gallery("4.11", "4.11-decay-fit", "Exponential fitted to an impulse response", "assumed")
FIGURE_4_13 = _of_gallery("4.13", "4.13-noise-window", "Focus in time, and the window of its noise", "calibrated")
FIGURE_4_15 = _of_gallery(
    "4.15 to 4.22", "4.15-four-signals", "The four driving signals in time and space", "calibrated"
)
FIGURE_4_25 = _of_gallery("4.25 to 4.27", "4.25-sound", "Sound of the four driving signals", "calibrated")
FIGURE_4_28 = _of_gallery("4.28", "4.28-layout", "Positions of transducers and foci", "assumed")
FIGURE_4_29 = _of_gallery("4.29", "4.29-amplitude-per-transducer", "Amplitude of each transducer alone", "calibrated")
FIGURE_4_30 = _of_gallery("4.30", "4.30-amplitude-over-count", "Amplitude against number of transducers", "calibrated")
FIGURE_4_31 = _of_gallery("4.31", "4.31-amplitude-by-subset", "Amplitude by subset of transducers", "calibrated")
FIGURE_4_33 = _figure(
    "4.32 and 4.33",
    "32 square transducers on one side of the plate",
    focusing.one_sided_layout,
    "assumed",
    "that 32 square transducers lie on one side",
)
FIGURE_4_34 = _figure("4.34", "Resolution of each focus, patches on one side", focusing.one_sided_resolution, "derived")
