"""`python builder_file.py FILE.psyexp`: an experiment with our components and loop, as PsychoPy's Builder saves it."""

import sys
from pathlib import Path

from psychopy import plugins
from psychopy.experiment import Experiment
from psychopy.experiment.components import getAllComponents
from psychopy.experiment.loops import getAllLoopTypes

SETTINGS = {
    "Full-screen window": False,
    "Window size (pixels)": (1280, 800),
    "Show info dlg": False,
    "Save csv file": False,
    "Save psydat file": False,
    "Save log file": False,
    "Data filename": "$'data'",
    "Experiment info": {"participant": "P01"},
    "Monitor": "",
    "measureFrameRate": False,
    "frameRate": "60",
}
OF_STUDY = {"study": "touch.toml", "bench": "bench.toml"}


def routine(experiment, name, *components):
    made = experiment.addRoutine(name)
    known = getAllComponents(fetchIcons=False)
    for kind, params in components:
        component = known[kind](experiment, name, name=params.pop("name"))
        for key, value in params.items():
            component.params[key].val = value
        made.addComponent(component)
    return made


def experiment():
    made = Experiment()
    for key, value in SETTINGS.items():
        made.settings.params[key].val = value
    text = ("TextComponent", {"name": "cross", "text": "+", "stopVal": "0.2"})
    trial = routine(made, "trial", text, ("GatedTouchComponent", {"name": "touch", "startVal": "0.2", **OF_STUDY}))
    beside = ("TactileStimulusComponent", {"name": "buzz", "level": "36", **OF_STUDY})
    after = routine(made, "after", beside, ("TextComponent", {"name": "words", "text": "...", "stopVal": "0.3"}))
    alone = routine(made, "alone", ("GatedTouchComponent", {"name": "felt", "level": "30", "asks": False, **OF_STUDY}))
    asked = routine(made, "asked", ("QuestionnaireComponent", {"name": "form", **OF_STUDY}))
    for each in (trial, after, alone, asked):
        made.flow.addRoutine(each, len(made.flow))
    loop = getAllLoopTypes()["TactometryLoop"](made, name="quest")
    for key, value in OF_STUDY.items():
        loop.params[key].val = value
    made.flow.addLoop(loop, startPos=0, endPos=1)
    return made


if __name__ == "__main__":
    plugins.activatePlugins()  # as the app does
    experiment().saveToXML(str(Path(sys.argv[1]).resolve()))
