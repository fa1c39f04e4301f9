"""Data classes for the tables of a study file."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import inf, isfinite, prod
from pathlib import Path
from typing import Any

from tactometry.arguments.constraints import Positive, constrained
from tactometry.arguments.require import expect, first_repeat, one_of, warning_of
from tactometry.config.strict import build
from tactometry.errors import InvalidParameter, nearest, rewording
from tactometry.observers.finger import SimulatedFinger
from tactometry.questionnaire import Questionnaire
from tactometry.rigs.texts import ImageTable
from tactometry.safety.limits import Limits
from tactometry.trials.cells import STUDY, cell
from tactometry.trials.columns import RESERVED

Prompt = str | dict[str, str]
"""Text for every language, or texts by two-letter language code."""
ASKED_BY = {"magnitude": ("how_strong",), "adjustment": ("adjust",), "measurement": ("vibrometer_nm",)}
"""Messages of tasks that ask for no choice."""


@dataclass(frozen=True)
class PromptTable:
    """Key `prompt` of the table `task`.

    - `prompt`: Question that replaces the built-in one: one text, or a text for each language.
    """

    prompt: Prompt = ""

    def __post_init__(self) -> None:
        check_prompt(self.prompt, "PromptTable.prompt")


def check_prompt(prompt: Prompt, where: str) -> None:
    """Raise `InvalidParameter` for a prompt with an empty text."""
    texts = prompt.values() if isinstance(prompt, dict) else [prompt or "?"]
    says_something = all(text.strip() for text in texts)
    expect(says_something, where, "an empty text", "the question for participants; or remove the key")


def by_language(prompt: Prompt) -> dict[str, str]:
    """Return a prompt by language. A single text counts as English.

    >>> by_language("Rough?"), by_language({"fr": "Rugueux ?"}), by_language("")
    ({'en': 'Rough?'}, {'fr': 'Rugueux ?'}, {})
    """
    return prompt if isinstance(prompt, dict) else {"en": prompt} if prompt else {}


def prompted(form: Questionnaire, prompt: Prompt) -> Questionnaire:
    """Return a questionnaire with the study's prompt as its stem."""
    return replace(form, stem=by_language(prompt)) if prompt else form


def messages_of(kind: str, questions: Iterable[str]) -> tuple[str, ...]:
    """Return the messages that present a task's questions.

    >>> messages_of("yes_no", ["felt"]), messages_of("magnitude", [])
    (('felt',), ('how_strong',))
    """
    return tuple(questions) or ASKED_BY.get(kind, ())


def texts_of(prompt: Prompt, messages: Iterable[str], language: str) -> dict[str, str]:
    """Return a prompt's text for each message, with its braces escaped.

    >>> texts_of("{Rough}?", ["felt"], "fr")
    {'felt': '{{Rough}}?'}
    """
    words = by_language(prompt)
    text = words.get(language, words.get("en", "")).replace("{", "{{").replace("}", "}}")
    return dict.fromkeys(messages, text) if text else {}


Levels = tuple[float | str, ...]


@dataclass(frozen=True)
@constrained
class PlanTable:
    """Division of cells into sessions and blocks, beyond `counterbalance`.

    - `between`: Between-participant factors. The participant's number selects the level.
    - `sessions`: Factors with one level per session.
    - `interleave`: Factors whose levels are interleaved in one block, as tracks.
    - `orders`: Factors by the rule of their order: ``williams`` (like those in `counterbalance`), ``complete`` or
      ``random``. Other factors have a fixed order.
    - `longest_s`: Latest time in a session at which a block may start.
    """

    between: tuple[str, ...] = ()
    sessions: tuple[str, ...] = ()
    interleave: tuple[str, ...] = ()
    orders: dict[str, tuple[str, ...]] = field(default_factory=dict)
    longest_s: Positive | None = None

    @property
    def rules(self) -> dict[str, str]:
        """Rules of order by factor."""
        return {name: rule for rule, names in self.orders.items() for name in names}

    @property
    def named(self) -> tuple[tuple[str, str], ...]:
        """Pairs of a key and a factor that it names."""
        lists = {"between": self.between, "sessions": self.sessions, "interleave": self.interleave}
        orders = {f"orders.{rule}": names for rule, names in self.orders.items()}
        return tuple((key, name) for key, names in (lists | orders).items() for name in names)


@dataclass(frozen=True)
class InquiryTable:
    """Questionnaire in addition to the task.

    - `form`: Name of a built-in questionnaire, or of one in `[forms]`.
    - `after`: Time of the questionnaire: ``start`` of the session, or after each ``block`` or the ``session``.
    - `shuffled`: Draw the order of the items separately for each participant.
    - `prompt`: Text above the pages, which replaces the stem: one text, or a text for each language.
    - `identifies`: Allow numbers about participants, which could identify them.
    """

    form: str
    after: str = "session"
    shuffled: bool = False
    prompt: Prompt = ""
    identifies: bool = False

    def __post_init__(self) -> None:
        check_prompt(self.prompt, "InquiryTable.prompt")
        one_of("InquiryTable.after", self.after, ("start", "block", "session"))


@dataclass(frozen=True)
class Study:
    """One experiment.

    Tables whose keys depend on `kind` are stored unchanged and built in `cells`. `analysis` contains the keys of
    `tactometry.analysis.plan.AnalysisPlan`.

    - `name`: Lower-case letters and digits, joined by hyphens. Used in file names and in the column `study`.
    - `title`: Title in reports and lists.
    - `description`: One or two sentences for those who read the data.
    - `task`: ``kind`` and keys of the task: the question for the participant.
    - `factors`: Levels of each factor, by name. All combinations are run.
    - `stimulus`: ``kind`` and keys of the stimulus: the played signal.
    - `touch`: ``kind`` and keys of the touch: the contact of the finger.
    - `procedure`: ``kind`` and keys of the procedure: the choice of the next level.
    - `limits`: Limits for every signal.
    - `counterbalance`: Factors whose order changes with the participant's number, outermost first.
    - `trial_s`: Assumed duration of a trial, for the estimate of `run --dry-run`.
    - `consent`: Ask for the participant's consent. If it is declined, the session ends.
    - `plan`: Table of the sessions, groups and orders of participants.
    - `nested`: Levels of a factor, by level of another factor.
    - `variants`: Changes to the tables stimulus, touch, procedure, sensation and scene, by level of a factor.
    - `practice`: Easy trials before the first block.
    - `inquiries`: Questionnaires in addition to the task, by name.
    - `forms`: Custom questionnaires by name. Each is a table, or the `path` of a file.
    - `scene`: Physics between stimulus and skin of simulated participants. Replaces `sensation`.
    - `sensation`: Sensation model of simulated participants.
    - `observer`: Decision model of simulated participants.
    - `finger`: Touch of simulated participants.
    - `texts`: Texts for participants by message, which replace the built-in ones.
    - `translations`: Texts by language, which override `texts`.
    - `images`: Pictures on pages, by message.
    - `analysis`: Analysis plan, stated before data collection.
    """

    name: str
    title: str
    description: str
    task: dict[str, Any]
    factors: dict[str, Levels]
    stimulus: dict[str, Any]
    touch: dict[str, Any]
    procedure: dict[str, Any]
    limits: Limits
    counterbalance: tuple[str, ...] = ()
    trial_s: float = 5.0
    consent: bool = False
    plan: PlanTable = field(default_factory=PlanTable)
    nested: dict[str, dict[str, dict[str, Levels]]] = field(default_factory=dict)
    variants: dict[str, dict[str, dict[str, dict[str, Any]]]] = field(default_factory=dict)
    practice: dict[str, Any] = field(default_factory=dict)
    inquiries: dict[str, InquiryTable] = field(default_factory=dict)
    forms: dict[str, dict[str, Any]] = field(default_factory=dict)
    scene: dict[str, Any] = field(default_factory=dict)
    sensation: dict[str, Any] = field(default_factory=dict)
    observer: dict[str, Any] = field(default_factory=dict)
    finger: SimulatedFinger = field(default_factory=SimulatedFinger)
    texts: dict[str, str] = field(default_factory=dict)
    translations: dict[str, dict[str, str]] = field(default_factory=dict)
    images: dict[str, ImageTable] = field(default_factory=dict)
    analysis: dict[str, Any] = field(default_factory=dict)
    _folder: Path = field(default=Path(), repr=False, compare=False)

    def __post_init__(self) -> None:
        is_name = STUDY.fullmatch(self.name) is not None
        expect(is_name, "name", repr(self.name), "lower-case letters and digits joined by hyphens")
        expect(len(self.name) <= LONGEST_NAME, "name", f"{len(self.name)} letters", f"at most {LONGEST_NAME}")
        expect(0 < self.trial_s < inf, "trial_s", f"{self.trial_s:g}", "above 0")
        _check_factors(self.factors)
        for n, name in enumerate(self.counterbalance):
            if name not in self.factors or name in self.counterbalance[:n]:
                raise no_such(f"counterbalance[{n}]", name, "each factor at most once", self.factors)
        _check_plan(self)
        if self.analysis:
            from tactometry.analysis.plan import AnalysisPlan

            with rewording(lambda words: words if words.startswith("analysis") else f"analysis.{words}"):
                build(AnalysisPlan, self.analysis, "analysis").check(list(self.factors))

    @property
    def cautions(self) -> tuple[str, ...]:
        """Warnings about permissive settings of the study, printed by a session."""
        return tuple(f"study, {warning_of(f'limits.{name}')}" for name in self.limits.switched_off)

    def beside(self, path: str) -> str:
        """Return a file's path relative to the study's folder, or unchanged.

        The path is unchanged if the file exists only there. A data set contains a copy of the study file without other
        files.
        """
        located = self._folder / path
        return path if Path(path).exists() and not located.exists() else str(located)

    def words_in(self, language: str) -> dict[str, str]:
        """Return the study's texts in a language, by its two-letter code."""
        return self.texts | self.translations.get(language, {})


def _check_factors(factors: Mapping[str, tuple[float | str, ...]]) -> None:
    for name, levels in factors.items():
        path = f"factors.{name}"
        expect(name not in RESERVED, path, "the name of a column in every trials table", "another name")
        expect(len(levels) > 0, path, "an empty list", "at least one level")
        _check_levels(path, levels)
    n_cells = prod(map(len, factors.values()))
    expect(n_cells <= MOST_CELLS, "factors", f"{n_cells} combinations of levels", f"at most {MOST_CELLS}")


def _check_levels(path: str, levels: Levels) -> None:
    for n, level in enumerate(levels):
        if isinstance(level, str):
            is_line = bool(level.strip()) and level.isprintable()
            expect(is_line, f"{path}[{n}]", repr(level), "a non-empty text of one line")
        else:
            expect(isfinite(level), f"{path}[{n}]", level, "a finite number or a text")
    n_again = first_repeat(_texts(levels))  # in nested or varied tables, a number and its text are the same level
    if n_again is not None:
        raise InvalidParameter(f"{path}[{n_again}]: found {levels[n_again]!r} twice, expected each level once")


def _check_plan(study: Study) -> None:
    """Reject unknown factors and levels in plan, nested levels and variants."""
    for key, name in study.plan.named:
        _check_name(name, study.factors, f"plan.{key}", "a factor")
    _check_places(study.plan)
    for outer, by_level in study.nested.items():
        _check_name(outer, study.factors, "nested", "a factor")
        for level, inner in by_level.items():
            _check_name(level, _texts(study.factors[outer]), f"nested.{outer}", "one of its levels")
            for name in inner:
                _check_name(name, study.factors, f"nested.{outer}.{level}", "a factor")
            _check_factors(inner)
    for name, changes in study.variants.items():
        _check_name(name, study.factors, "variants", "a factor")
        for level, tables in changes.items():
            _check_name(level, _texts(study.factors[name]), f"variants.{name}", "one of its levels")
            for table in tables:
                _check_name(table, VARIED, f"variants.{name}.{level}", "a table")


def _check_places(plan: PlanTable) -> None:
    """Reject a factor in two keys of the plan."""
    placed: dict[str, str] = {}
    for key in ("between", "sessions", "interleave"):
        for name in getattr(plan, key):
            twice = f"{name!r}, which is also in plan.{placed.get(name)}"
            expect(name not in placed, f"plan.{key}", twice, "each factor once")
            placed[name] = key


LONGEST_NAME, MOST_CELLS = 100, 2000
"""Longest name of a study, as it is part of file names, and largest number of cells."""
VARIED = ("stimulus", "touch", "procedure", "sensation", "scene")


def _texts(levels: Levels) -> list[str]:
    return [cell(level) for level in levels]


def _check_name(name: str, known: Collection[str], where: str, what: str) -> None:
    if name not in known:
        raise no_such(where, name, what, known)


def no_such(where: str, name: str, what: str, known: Collection[str]) -> InvalidParameter:
    """Return an error for an unknown name that lists known and similar names."""
    return InvalidParameter(f"{where}: found {name!r}, expected {what} ({', '.join(known)}){nearest(name, known)}")
