"""PsychoPy Builder components, and a loop. Both generate experiment code.

The classes are entry points in pyproject.toml. Builder loads this module when it starts, so it imports no other module
of Tactometry. The generated code uses `parts`.
"""

import warnings
from typing import Any, ClassVar

with warnings.catch_warnings():  # ignore warnings of PsychoPy's import
    warnings.simplefilter("ignore")
    from psychopy.experiment.components import BaseComponent, Param
    from psychopy.experiment.loops import _BaseLoopHandler

PARTS = "tactometry.experiments.psychopy_plugin.parts"
PLUGIN = "tactometry"
OF_STUDY = ("study", "bench", "factors")


def _param(value: Any, kind: str, label: str, hint: str, entry: str = "single") -> Param:
    return Param(value, valType=kind, inputType=entry, categ="Basic", updates="constant", label=label, hint=hint)


def _params_of_study() -> dict[str, Param]:
    study = "Study file, or name of a built-in study. It states stimulus, touch, task, procedure and limits"
    bench = "Bench file: output, force sensor, calibration. Without it, nothing is played"
    return {
        "study": _param("touch.toml", "str", "Study", study, "file"),
        "bench": _param("", "str", "Bench", bench, "file"),
        "factors": _param("{}", "code", "Factors", "Condition, if the study has several: {'frequency_hz': 120}"),
    }


def _level() -> Param:
    hint = "Level in the unit of the stimulus. Inside a study's loop, use level. None: no stimulus"
    return _param("level", "code", "Level", hint)


class _StudyComponent(BaseComponent):  # type: ignore[misc]
    """Component with a study and a bench, which ends without a set duration."""

    categories: ClassVar = ["Touch"]
    targets: ClassVar = ["PsychoPy"]
    plugin = PLUGIN
    version = "2026.2.0"
    part = ""

    def __init__(self, exp: Any, parentName: str, name: str = "touch", **more: Any) -> None:
        start = {"startVal": "0.0", "stopVal": "", "saveStartStop": False, "syncScreenRefresh": False}
        super().__init__(exp, parentName, name, **(start | more))
        self.type = type(self).__name__
        self.params |= _params_of_study()
        self.order += [*OF_STUDY]
        for idle in ("stopVal", "stopType", "durationEstim"):
            self.hideParam(idle)
        exp.requireImport(importName=self.part, importFrom=PARTS)

    @property
    def _made(self) -> str:
        return ""

    def writeInitCode(self, buff: Any) -> None:  # noqa: N802
        code = f"%(name)s = {self.part}(win, %(study)s, %(bench)s, %(factors)s{self._made})\n"
        buff.writeIndentedLines(code % self.params)

    def _write_start(self, buff: Any, code: str) -> None:
        indented = self.writeStartTestCode(buff)
        buff.writeIndentedLines(code % self.params)
        buff.setIndentLevel(-indented, relative=True)


RUN = """
if not {call}:
    thisExp.status = FINISHED  # Escape
%(name)s.status = FINISHED
"""
PLAY_ON = """
if %(name)s.status == STARTED and not %(name)s.plays():
    %(name)s.status = FINISHED
if %(name)s.stopped:
    thisExp.status = FINISHED  # Escape
"""
KEEP = """
for _name, _value in %(name)s.values.items():
    thisExp.addData("%(name)s." + _name, _value)
"""


class GatedTouchComponent(_StudyComponent):
    """Gated touch with an optional question, on pages of Tactometry.

    The participant is guided to the target force, feels the stimulus and, with `asks`, answers the study's question.
    """

    tooltip = "Gated touch: a stimulus that plays while the finger keeps its force, and the study's question"
    part = "TouchPart"

    def __init__(self, exp: Any, parentName: str, name: str = "touch", **more: Any) -> None:
        super().__init__(exp, parentName, name, **more)
        self.params["level"] = _level()
        hint = "Ask the study's question. The study's loop around the routine receives the answer"
        self.params["asks"] = _param(True, "bool", "Ask", hint, "bool")
        self.order += ["level", "asks"]

    @property
    def _made(self) -> str:
        return ", asks=%(asks)s"

    def writeFrameCode(self, buff: Any) -> None:  # noqa: N802
        self._write_start(buff, RUN.format(call="%(name)s.run(%(level)s)"))

    def writeRoutineEndCode(self, buff: Any) -> None:  # noqa: N802
        inner = self.exp.flow._loopList[-1:]
        names = [loop.name for loop in inner if isinstance(loop, TactometryLoop) and self.params["asks"].val]
        code = f"{names[0]}.hear(%(name)s.outcome)\n" if names else KEEP
        buff.writeIndentedLines(code % self.params)


class TactileStimulusComponent(_StudyComponent):
    """Stimulus that plays during a routine, whether or not a finger touches."""

    tooltip = "Tactile stimulus: plays during the routine, within the limits of study and bench"
    part = "StimulusPart"

    def __init__(self, exp: Any, parentName: str, name: str = "stimulus", **more: Any) -> None:
        super().__init__(exp, parentName, name, **more)
        self.params["level"] = _level()
        self.order += ["level"]

    def writeFrameCode(self, buff: Any) -> None:  # noqa: N802
        self._write_start(buff, "%(name)s.start(%(level)s)\n")
        buff.writeIndentedLines(PLAY_ON % self.params)

    def writeRoutineEndCode(self, buff: Any) -> None:  # noqa: N802
        buff.writeIndentedLines(("%(name)s.finish()\n" + KEEP) % self.params)


class QuestionnaireComponent(_StudyComponent):
    """Questionnaire on pages of Tactometry, with one data row per item."""

    tooltip = "Questionnaire: AttrakDiff, NASA-TLX, SUS, demographics, or a custom form of the study"
    part = "FormPart"

    def __init__(self, exp: Any, parentName: str, name: str = "questionnaire", **more: Any) -> None:
        super().__init__(exp, parentName, name, **more)
        hint = "attrakdiff, nasa-tlx, sus, demographics, ..., or a name in the study's [forms]"
        self.params["form"] = _param("attrakdiff", "str", "Form", hint)
        self.order += ["form"]

    def writeFrameCode(self, buff: Any) -> None:  # noqa: N802
        self._write_start(buff, RUN.format(call="%(name)s.run(%(form)s, thisExp)"))


LOOP_START = """
# procedure of %(study)s: the answers determine each level
%(name)s = loop_of("%(name)s", win, %(study)s, %(bench)s, %(factors)s)
thisExp.addLoop(%(name)s)
for level in %(name)s:
"""
LOOP_END = """
thisExp.addData("%(name)s.threshold", %(name)s.threshold)
thisExp.addData("%(name)s.ending", %(name)s.ending)
thisExp.nextEntry()
"""


class TactometryLoop(_BaseLoopHandler):  # type: ignore[misc]
    """Loop over the levels of the study's procedure.

    Builder's other components treat the loop as a staircase. A keyboard component that stores correctness passes each
    answer to the loop.
    """

    tag = "TactometryLoop"
    label = "Procedure of a study"
    plugin = PLUGIN

    def __init__(self, exp: Any, name: str = "quest", **unused: Any) -> None:
        super().__init__()
        del unused
        self.type, self.exp = "StairHandler", exp
        self.children: list[Any] = []
        self.params = {
            "name": Param(
                name, valType="code", inputType="name", categ=None, label="Name", hint="Prefix of the loop's columns"
            ),
            **_params_of_study(),
            "isTrials": Param(
                True, valType="bool", inputType="bool", updates=None, allowedUpdates=None, categ=None,
                label="Is trials", hint="Store a data row for each repetition",
            ),
        }  # fmt: skip
        self.order = [*self.params]
        exp.requireImport(importName="loop_of", importFrom=PARTS)

    @property
    def name(self) -> str:
        name: str = self.params["name"].val
        return name

    def getType(self) -> str:  # noqa: N802
        """Return the loop type for Builder's flow: a staircase."""
        return self.type

    def writeLoopStartCode(self, buff: Any) -> None:  # noqa: N802
        self.thisName = "level"
        buff.writeIndentedLines(LOOP_START % self.params)
        buff.setIndentLevel(1, relative=True)
        buff.writeIndentedLines(f"currentLoop = {self.name}\n")

    def writeLoopEndCode(self, buff: Any) -> None:  # noqa: N802
        if self.params["isTrials"].val:
            buff.writeIndentedLines("thisExp.nextEntry()\n")
        buff.setIndentLevel(-1, relative=True)
        buff.writeIndentedLines(LOOP_END % self.params)
