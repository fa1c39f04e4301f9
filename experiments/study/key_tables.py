"""The tables of a study file by their place, each with the class that reads it; and the same as pages of the docs.

`python -m tactometry.experiments.study.key_tables` (`make keys`) writes them into `docs/reference/studies.md` and
`docs/reference/procedures.md`.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

from tactometry.analysis.plan import AnalysisPlan
from tactometry.analysis.reading.quality import Exclusion
from tactometry.choice_form import ChoiceForm, ChoiceItem, Option
from tactometry.loading import resolve
from tactometry.observers.changes.kinds import CHANGES
from tactometry.observers.finger import SimulatedFinger
from tactometry.observers.kinds import OBSERVERS, USUAL
from tactometry.observers.people import People
from tactometry.observers.raters import Raters
from tactometry.protocols.block_state import BlockOptions
from tactometry.protocols.procedures.practice import Practice
from tactometry.questionnaire import Dimension, Item, Questionnaire
from tactometry.rigs.images import ImageTable
from tactometry.rigs.texts import texts_in
from tactometry.safety.limits import Limits
from tactometry.stimuli.electrovibration import CoulombFriction, FrictionLag, Grating, Layer, Polarity, Skin
from tactometry.stimuli.electrovibration.textures.kinds import TEXTURES
from tactometry.stimuli.electrovibration.waveforms.kinds import WAVEFORMS
from tactometry.stimuli.time_reversal.stimulus.placed_foci import Place
from tactometry.stimuli.time_reversal.stimulus.setup import Setup

from .cells import ELECTROVIBRATION, STIMULI, TOUCHES
from .keys import Key, KeyTable, keys_of
from .procedure_table import PROCEDURES
from .prompts import PromptTable
from .scene_table import SceneTable
from .study_file import InquiryTable, PlanTable, Study
from .task_table import TASKS

BEGIN, END = "<!-- keys: written by `make keys` -->", "<!-- end of keys -->"
ROOT: Final = Path(__file__).resolve().parents[2]

_TOP = {
    "name": "a", "title": "A", "description": "It.", "task": {}, "factors": {"force_n": [1.0]}, "stimulus": {},
    "touch": {}, "procedure": {}, "limits": {"voltage_peak_v": 100.0},
}  # fmt: skip
_TOUCH = {"force_n": 1.0, "hold_s": 0.3, "timeout_s": 10.0}
_TOUCHES: Final[Mapping[str, Mapping[str, object]]] = {"press": _TOUCH, "slide": {**_TOUCH, "speed_m_per_s": 0.05}}
_FOCUS = {"setup": {"n_transducers": 4, "modes_to_hz": 4e3, "rate_hz": 10e3}, "f_max_hz": 3e3}
_PLACES: Final[Mapping[str, object]] = {"index": {"x_m": 0.1}, "middle": {"x_m": 0.12}}
_BOTH = {
    "focus": _FOCUS,
    "friction": {"frequency_hz": 120.0, "carrier_hz": 1e3, "duration_s": 0.5, "rate_hz": 10e3},
}
_WAV = {"path": "buzz.wav", "rate_hz": 48e3, "duration_s": 0.5}
_OBSERVERS: Final[Mapping[str, Mapping[str, object]]] = {"psychometric": {"threshold": 26.0}}
OF_SETUP: Final = ("focus", "measured_focus", "foci", "hybrid")
"""A kind for each model of what is felt of a screen."""
_ITEM = {"id": "Q1", "dimension": "D", "order": 1, "statement": {"en": "It."}}
_FORM = {
    "title": "A", "low": 0.0, "high": 10.0, "steps": 11, "score_low": 0.0, "score_high": 10.0, "items": [_ITEM],
    "dimensions": {"D": {"min_answered": 1}}, "reference": "none", "ends": {"en": ["no", "yes"]},
}  # fmt: skip
_OPTIONS = [{"code": 1, "words": {"en": "yes"}}, {"code": 2, "words": {"en": "no"}}]
_CHOICE_ITEM = {"id": "Q1", "prompt": {"en": "Is it?"}, "options": _OPTIONS}
_CHOICES = {"title": "A", "reference": "none", "kind": "choices", "items": [_CHOICE_ITEM]}
_IN_LEVELS = (
    "start", "steps", "steps_up", "steps_down", "step", "low", "high", "levels", "start_sd", "sd_stop", "decade",
    "width_low", "width_high", "threshold_low", "threshold_high", "sd_low", "sd_high", "standard_level",
)  # fmt: skip


def study_tables() -> Iterator[tuple[str, KeyTable]]:
    """The tables of a study file but `[procedure]`, by a heading."""
    yield "The file itself", KeyTable(Study, _TOP)
    yield from _stimuli()
    yield "`[stimulus.setup]`", KeyTable(Setup)
    yield "`[stimulus.places.NAME]`", KeyTable(Place)
    yield from ((f'`[touch]`, `kind = "{kind}"`', _touch(kind)) for kind in TOUCHES)
    yield "`[task]`, every kind", KeyTable(BlockOptions)
    yield "`[task]`, every kind: what is asked", KeyTable(PromptTable)
    yield from ((f'`[task]`, `kind = "{kind}"`', table) for kind, table in _tasks())
    yield "`[practice]`", KeyTable(Practice, {"levels": [30.0]}, in_levels=_IN_LEVELS)
    yield "`[plan]`", KeyTable(PlanTable)
    yield "`[images.MESSAGE]`", KeyTable(ImageTable, {"path": "setup.png"})
    yield "`[inquiries.NAME]`", KeyTable(InquiryTable, {"form": "sus"})
    yield "`[forms.NAME]`", KeyTable(Questionnaire, _FORM, given={"name": "own"})
    yield "`[[forms.NAME.items]]`", KeyTable(Item, _ITEM)
    yield "`[forms.NAME.dimensions.NAME]`", KeyTable(Dimension, {"min_answered": 1})
    yield '`[forms.NAME]`, `kind = "choices"`', KeyTable(ChoiceForm, _CHOICES, given={"name": "own"})
    yield '`[[forms.NAME.items]]`, `kind = "choices"`', KeyTable(ChoiceItem, _CHOICE_ITEM)
    yield '`[[forms.NAME.items.options]]`, `kind = "choices"`', KeyTable(Option, _OPTIONS[0])
    yield "`[limits]`", KeyTable(Limits, {"voltage_peak_v": 100.0})
    yield "`[scene]`", KeyTable(SceneTable)
    yield "`[sensation]`, electrovibration", KeyTable(resolve(ELECTROVIBRATION))
    yield "`[sensation.skin]`", KeyTable(Skin)
    yield "`[sensation.skin.tissue]`", KeyTable(Layer, {"thickness_m": 5e-3})
    yield "`[sensation.friction]`", KeyTable(CoulombFriction)
    yield "`[sensation.lag]`", KeyTable(FrictionLag)
    yield "`[sensation.polarity]`", KeyTable(Polarity, {"positive_share": 0.5})
    yield from ((f"`[sensation]`, `{kind}`", _sensation_table(kind)) for kind in OF_SETUP)
    yield from _observers()
    yield "`[observer.people]`", KeyTable(People)
    yield "`[observer.raters]`", KeyTable(Raters)
    yield from ((f"`[observer.changes.{kind}]`", KeyTable(resolve(target))) for kind, target in CHANGES.items())
    yield "`[finger]`", KeyTable(SimulatedFinger)
    yield "`[analysis]`", KeyTable(AnalysisPlan)
    yield "`[analysis.exclusion]`", KeyTable(Exclusion)


def procedure_tables() -> Iterator[tuple[str, KeyTable]]:
    """The table `[procedure]` of each kind."""
    for kind, read in PROCEDURES.items():
        table = KeyTable(read.table, read.example, made=read.rule, in_levels=_IN_LEVELS)
        yield f'`kind = "{kind}"`', table


def texts() -> Mapping[str, str]:
    """The messages and labels that `[texts]` may replace, as they are shipped, in the order of their file."""
    shipped = texts_in("en", {})
    return {**shipped.messages, **shipped.labels}


def with_tables(page: str, tables: Iterable[tuple[str, KeyTable]], behind: str = "") -> str:
    """A page with its tables of keys anew, between the marks."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    parts = [f"### {heading}\n\n{_rows(keys_of(table))}" for heading, table in tables]
    return "\n\n".join([f"{before}{BEGIN}", *parts, *filter(None, [behind]), f"{END}{after}"])


def pages() -> dict[Path, str]:
    """The pages that hold keys, as they should be."""
    studies, procedures = (ROOT / "docs" / "reference" / f"{page}.md" for page in ("studies", "procedures"))
    return {
        studies: with_tables(studies.read_text(encoding="utf-8"), study_tables(), _texts_in_words()),
        procedures: with_tables(procedures.read_text(encoding="utf-8"), procedure_tables()),
    }


def _stimuli() -> Iterator[tuple[str, KeyTable]]:
    """Kinds that one class reads stand together."""
    examples = {kind: wave.example for kind, wave in WAVEFORMS.items()}
    examples |= {"focus": _FOCUS, "foci": {**_FOCUS, "places": _PLACES, "place": "index"}}
    examples |= {"hybrid": _BOTH, "texture": {}, "wav": _WAV}
    for target in dict.fromkeys(kind.stimulus for kind in STIMULI.values()):
        kinds = [name for name, kind in STIMULI.items() if kind.stimulus == target]
        names = ", ".join(f'"{kind}"' for kind in kinds)
        made = {"texture": Grating(2e-3)} if kinds == ["texture"] else {"read": False} if kinds == ["wav"] else {}
        parts = STIMULI[kinds[0]].parts
        yield f"`[stimulus]`, `kind = {names}`", KeyTable(resolve(target), examples[kinds[0]], made, kinds=parts)
    for kind, texture in TEXTURES.items():
        yield f'`[stimulus.texture]`, `kind = "{kind}"`', KeyTable(resolve(texture.target), texture.example)


def _touch(kind: str) -> KeyTable:
    return KeyTable(TOUCHES[kind], _TOUCHES[kind], given={"duration_s": 0.5})


def _tasks() -> Iterator[tuple[str, KeyTable]]:
    """Those kinds that have keys of their own."""
    for kind, read in TASKS.items():
        table = KeyTable(read.table, read.example, in_levels=_IN_LEVELS)
        if keys_of(table):
            yield kind, table


def _observers() -> Iterator[tuple[str, KeyTable]]:
    for kind, target in OBSERVERS.items():
        table = KeyTable(resolve(target), _OBSERVERS.get(kind, {}), in_levels=("threshold", "width"))
        yield "`[observer]`" if kind == USUAL else f'`[observer]`, `kind = "{kind}"`', table


def _sensation_table(kind: str) -> KeyTable:
    known = {
        "setup": Setup(**_FOCUS["setup"]),  # type: ignore[arg-type]
        "places": {name: Place(**place) for name, place in _PLACES.items()},  # type: ignore[arg-type]
    }
    return KeyTable(resolve(STIMULI[kind].sensation), given={name: known[name] for name in STIMULI[kind].shared})


def _rows(keys: Iterable[Key]) -> str:
    rows = ["| key | holds | unit | range | if left out |", "|---|---|---|---|---|"]
    for key in keys:
        otherwise = "**required**" if key.required else key.otherwise
        rows.append(f"| `{key.name}` | {key.holds} | {key.unit} | {key.within} | {otherwise} |")
    return "\n".join(rows)


def _texts_in_words() -> str:
    rows = [f"| `{name}` | {' '.join(text.split())} |" for name, text in texts().items()]
    return "\n".join(["### `[texts]`", "", "| name | as shipped |", "|---|---|", *rows])


def main() -> None:
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
