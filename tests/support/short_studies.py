"""Short versions of the built-in studies with every kind of page."""

import re

from places import ROOT
from study_texts import TUTORIAL, changed


def text_of(name):
    return (ROOT / "experiments" / f"{name}.toml").read_text("utf-8")


def without(name, lines):
    return tuple((line, "") for line in re.findall(lines, text_of(name), re.MULTILINE))


FAST = (('hold_s = "500 ms"', 'hold_s = "50 ms"'), ('hold_s = "300 ms"', 'hold_s = "50 ms"'))
SHORT = {
    "tutorial": (
        ("frequency_hz = [60, 240]", "frequency_hz = [60]"),
        ("levels = [22, 28, 34, 40]", "levels = [22, 40]"),
        ("repeats = 4", "repeats = 1"),
    ),
    "time-reversal-threshold": (
        ("force_n = [0.5, 1.5, 3.0] ", "force_n = [0.5] "),
        ("levels = [10.0, 14.0, 18.0, 22.0, 26.0, 30.0]\nrepeats = 20", "levels = [20.0, 28.0]\nrepeats = 1"),
        ("n_correct = 4 ", "n_correct = 1 "),
    ),
    "time-reversal-patterns": (
        ('["P0", "P1", "P2", "P3", "P4", "P5", "P6"]', '["P0", "P4"]'),
        *without("time-reversal-patterns", r"^P[12356] = .*\n"),
        ('form = "attrakdiff" ', 'form = "attrakdiff-haptic" '),
        ("n_touches = 3 ", "n_touches = 1 "),
    ),
    "time-reversal-localisation": (
        ("[0.010, 0.013, 0.017, 0.022, 0.028, 0.036, 0.050]", "[0.028]"),
        *without("time-reversal-localisation", r'^"0\.0(?!28).*\n'),
        ("n_correct = 6 ", "n_correct = 1 "),
        ("repeats = 30", "repeats = 3"),
    ),
    "hybrid-button": (("repeats = 2", "repeats = 1"), ("n_touches = 2", "n_touches = 1")),
    "electrovibration-threshold": (
        ("force_n = [0.5, 1.5, 3.0] ", "force_n = [1.5] "),
        ("frequency_hz = [30, 60, 120, 180, 240, 320, 480]", "frequency_hz = [240]"),
        ("n_trials = 40", "n_trials = 4"),
    ),
    "grating-roughness": (
        ("period_m = [0.0005, 0.001, 0.002, 0.004] ", "period_m = [0.002] "),
        *without("grating-roughness", r'^"0\.00(?!2).*\n'),
        ("levels = [22, 28, 34, 40, 46] ", "levels = [34] "),
        ("repeats = 4", "repeats = 3"),
    ),
    "force-loss": (
        ('contactor = ["finger", "soft 5 mm", "soft 10 mm", "rigid 5 mm", "rigid 10 mm"]', 'contactor = ["soft 5 mm"]'),
        *without("force-loss", r'^\[variants\.contactor\.(?!"soft 5 mm").*\n(?:[a-z].*\n)+'),
        *without("force-loss", r'^(?:finger|"soft 10 mm"|"rigid (?:5|10) mm") = .*\n'),
        ('place = ["F", "P1"] ', 'place = ["F"] '),
        *without("force-loss", r"^\[variants\.place\.P1.*\n(?:[a-z].*\n)+"),
        ("force_n = [0.1, 0.5, 1.0, 2.0, 4.0]", "force_n = [0.5, 2.0]"),
        ("repeats = 3", "repeats = 1"),
    ),
}


def shortened(name):
    """Shorten a built-in study to few trials and short holds."""
    text = changed(TUTORIAL if name == "tutorial" else text_of(name), dict(SHORT[name]))
    for old, new in FAST:
        text = text.replace(old, new)
    return text
