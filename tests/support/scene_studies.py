"""Studies with a scene of their own: the tutorial felt through effects, and a study of foci."""

from study_texts import TUTORIAL

from tactometry.experiments.study.study_file import load

FOCI = load("time-reversal-threshold")[1].decode()
EFFECT_LINES = {
    "force_law": '{ kind = "force_law", law = "sc_layer" }',
    "friction": '{ kind = "friction" }',
    "sensitivity": '{ kind = "sensitivity" }',
}
SHORT = {"[60, 240]": "[60]", "levels = [22, 28, 34, 40]": "levels = [10, 34]", "repeats = 4": "repeats = 1"}
"""Changes that shorten the tutorial study to four trials."""


def scene(*lines, **keys):
    effects = ", ".join(lines or EFFECT_LINES.values())
    more = "".join(f"{key} = {value}\n" for key, value in keys.items())
    return f"{TUTORIAL}\n[scene]\n{more}effects = [{effects}]\n"
