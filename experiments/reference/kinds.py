"""Fields of the reference tables of each kind whose registry names more than a class."""

from collections.abc import Mapping
from operator import methodcaller
from typing import Final

from tactometry.stimuli.electrovibration.textures.kinds import TEXTURES
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS
from tactometry.trials.tasks import TASKS

from ..study.kinds import PROCEDURES, STIMULI, ProcedureKind
from .tables import Values


def _procedure(known: ProcedureKind) -> Values:
    made = {"made": methodcaller(known.rule)} if known.rule else {}
    also = ("procedure",) if known.takes_easy_trials else ()
    return {"reads": known.table, "example": known.example, "also": also, **made}


_EXAMPLES: Final = {kind: {"example": waveform.example} for kind, waveform in WAVEFORMS.items()}
STIMULUS_TABLES: Final[Mapping[str, Values]] = {
    kind: {"reads": known.stimulus, "kinds": known.parts, **_EXAMPLES.get(kind, {})} for kind, known in STIMULI.items()
}
TEXTURE_TABLES: Final[Mapping[str, Values]] = {
    kind: {"reads": texture.target, "example": texture.example} for kind, texture in TEXTURES.items()
}
TASK_TABLES: Final[Mapping[str, Values]] = {
    kind: {"reads": f"{task}.table", "example": f"{task}.example"}
    for kind, task in ((kind, f"tactometry.protocols.tasks.{kind}:TASK") for kind in TASKS)
}
PROCEDURE_TABLES: Final[Mapping[str, Values]] = {kind: _procedure(known) for kind, known in PROCEDURES.items()}
