"""Run, simulate and analyse psychophysics experiments on touch.

The names in `__all__` are those that most scripts need. `tactometry.stimuli`, `tactometry.protocols` and
`tactometry.analysis` export further names. A name is imported when it is first used.
"""

from typing import Any

from .loading import resolve

__version__ = "0.1.0"

_MODULE_OF = {
    "ConstantStimuli": "protocols",
    "PsychometricFunction": "psychometric",
    "QuestPlus": "protocols",
    "Scene": "stimuli.scenes.scene",
    "Staircase": "protocols",
    "analyse": "analysis",
    "fit": "analysis",
    "fit_hierarchical": "analysis",
    "load_scene": "stimuli.scenes.file",
    "read_trials": "analysis",
    "run": "experiments.scripting",
    "simulate": "experiments.scripting",
    "write_report": "analysis",
}
__all__ = sorted(_MODULE_OF)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return resolve(f"{__name__}.{_MODULE_OF[name]}:{name}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
