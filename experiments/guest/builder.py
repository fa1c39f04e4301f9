"""PsychoPy Builder components and a loop that generate experiment code.

PsychoPy's plug-ins are entry points of a package; those of Tactometry are in pyproject.toml. Builder loads this module
at its start, so the module imports nothing else of Tactometry. The generated code uses
`tactometry.experiments.guest.parts`.
"""

import warnings
from typing import Any, ClassVar

with warnings.catch_warnings():  # ignore PsychoPy's warnings at import
    warnings.simplefilter("ignore")
    from psychopy.experiment.components import BaseComponent, Param
    from psychopy.experiment.loops import _BaseLoopHandler

PARTS = "tactometry.experiments.guest.parts"
PLUGIN = "tactometry"
OF_STUDY = ("study", "bench", "factors")


def _params_of_study() -> dict[str, Param]:
    return {
        "study": Param(
            "touch.toml", valType="str", inputType="file", categ="Basic", updates="constant",
            label="Study", hint="A study file, or a built-in study's name: stimulus, touch, task, procedure, limits",
        ),
        "bench": Param(
            "", valType="str", inputType="file", categ="Basic", updates="constant",
            label="Bench", hint="A bench file: output, force sensor, calibration. Without one nothing is played",
        ),
        "factors": Param(
            "{}", valType="code", inputType="single", categ="Basic", updates="constant",
            label="Factors", hint="The cell of a study that has several, as {'frequency_hz': 120}",
        ),
    }  # fmt: skip


def _level() -> Param:
    return Param(
        "level", valType="code", inputType="single", categ="Basic", updates="constant",
        label="Level", hint="In the unit of the stimulus; a loop of ours calls it level. None: a blank",
    )  # fmt: skip


class _GuestComponent(BaseComponent):  # type: ignore[misc]
    """Component with a study and a bench; it ends by itself."""

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


class GatedTouchComponent(_GuestComponent):
    """Gated touch with an optional question, on pages of Tactometry.

    The participant is guided to the target force, feels the stimulus and, with `asks`, answers the study's question.
    """

    tooltip = "Gated touch: a stimulus that plays while the finger holds its force, and the study's question"
    part = "TouchPart"

    def __init__(self, exp: Any, parentName: str, name: str = "touch", **more: Any) -> None:
        super().__init__(exp, parentName, name, **more)
        self.params["level"] = _level()
        self.params["asks"] = Param(
            True, valType="bool", inputType="bool", categ="Basic", updates="constant",
            label="Ask", hint="Ask the study's question; the answer goes to the loop of ours that the routine is in",
        )  # fmt: skip
        self.order += ["level", "asks"]

    @property
    def _made(self) -> str:
        return ", asks=%(asks)s"

    def writeFrameCode(self, buff: Any) -> None:  # noqa: N802
        self._write_start(buff, RUN.format(call="%(name)s.run(%(level)s)"))

    def writeRoutineEndCode(self, buff: Any) -> None:  # noqa: N802
        inner = self.exp.flow._loopList[-1:]
        heard = [loop.name for loop in inner if isinstance(loop, TactometryLoop) and self.params["asks"].val]
        code = f"{heard[0]}.hear(%(name)s.outcome)\n" if heard else KEEP
        buff.writeIndentedLines(code % self.params)


class TactileStimulusComponent(_GuestComponent):
    """Stimulus that plays during a routine, whether or not a finger touches."""

    tooltip = "Tactile stimulus: plays while the routine goes on, within the limits of study and bench"
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


class QuestionnaireComponent(_GuestComponent):
    """Questionnaire on pages of Tactometry, with one data row per item."""

    tooltip = "Questionnaire: AttrakDiff, NASA-TLX, SUS, questions about a person, or one of the study's own"
    part = "FormPart"

    def __init__(self, exp: Any, parentName: str, name: str = "questionnaire", **more: Any) -> None:
        super().__init__(exp, parentName, name, **more)
        self.params["form"] = Param(
            "attrakdiff", valType="str", inputType="single", categ="Basic", updates="constant",
            label="Form", hint="attrakdiff, nasa-tlx, sus, demographics, ..., or one in the study's [forms]",
        )  # fmt: skip
        self.order += ["form"]

    def writeFrameCode(self, buff: Any) -> None:  # noqa: N802
        self._write_start(buff, RUN.format(call="%(name)s.run(%(form)s, thisExp)"))


LOOP_START = """
# the procedure of %(study)s: each level is the one that the answers ask for
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

    Builder's other components treat it as a staircase: a keyboard that stores correctness passes each answer to it.
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
                name, valType="code", inputType="name", categ=None, label="Name", hint="Before the names of its columns"
            ),
            **_params_of_study(),
            "isTrials": Param(
                True, valType="bool", inputType="bool", updates=None, allowedUpdates=None, categ=None,
                label="Is trials", hint="A row of data for each time round",
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
