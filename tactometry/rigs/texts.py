"""Participant's texts and images, from the study or a shipped language file."""

import io
import re
import string
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Final

from ..arguments.require import expect, one_of
from ..errors import InvalidParameter, nearest, rewording
from ..files.durable import read_file
from ..provenance import sha256
from ..session.request import Question, Show

_WIDE = re.compile(r"\d{4}")
FOLDER = Path(__file__).parent
PREFIX, SUFFIX = "messages_", ".toml"
LIST: Final = "the list printed by tactometry keys texts"
N_NEAREST: Final = 3
"""Number of similar names suggested for an unknown one."""
LARGEST_IMAGE = 50_000_000
"""Largest size of an image file, bytes."""


@dataclass(frozen=True)
class ImageTable:
    """Image of a page.

    - `path`: A PNG or JPEG file, relative to the study file.
    - `sha256`: SHA-256 of the file. If it is wrong, the error message states the correct value.
    """

    path: str
    sha256: str = ""


@dataclass(frozen=True)
class PageImage:
    """File of an image, and its ratio of width to height."""

    path: str
    ratio: float


def image_of(table: ImageTable, where: str) -> PageImage:
    """Check the image of a table and return its file and proportions.

    Raises `InvalidParameter` if the file cannot be read, its SHA-256 differs from the table, or it is not an image.
    """
    from PIL import Image as Pillow, UnidentifiedImageError

    path = Path(table.path)
    with rewording(lambda words: f"{where}.path: {words}; the path is relative to the study file"):
        content = read_file(path, "an image", LARGEST_IMAGE)
    digest = sha256(content)
    is_this = f"that of {path}, {digest!r}; add it, so that no other file is shown instead"
    expect(table.sha256 == digest, f"{where}.sha256", repr(table.sha256) if table.sha256 else "no such key", is_this)
    try:
        width, height = Pillow.open(io.BytesIO(content)).size
    except (UnidentifiedImageError, OSError, Pillow.DecompressionBombError):
        width = height = 0
    expect(width > 0, f"{where}.path", f"{table.path!r}, which is not an image", "a PNG or JPEG file")
    return PageImage(str(path.resolve()), width / height)


@cache
def languages() -> tuple[str, ...]:
    """Return the two-letter codes of the shipped languages."""
    return tuple(sorted(path.stem.removeprefix(PREFIX) for path in FOLDER.glob(f"{PREFIX}*{SUFFIX}")))


@dataclass(frozen=True)
class Texts:
    """Messages and labels by name.

    - `messages`: Texts with ``{names}`` to fill.
    - `labels`: Labels of answers and levels in the participant's language.
    - `language`: Two-letter code.
    - `stop`: Label of the key that stops a session.
    - `shipped`: Fallback for messages of the study that cannot be filled in.
    - `images`: Images on pages of text, by name of the message.
    """

    messages: Mapping[str, str]
    labels: Mapping[str, str] = field(default_factory=dict)
    language: str = "en"
    shipped: Mapping[str, str] = field(default_factory=dict)
    stop: str = "escape"
    images: Mapping[str, PageImage] = field(default_factory=dict)

    def question(self, question: Question) -> tuple[str, str, str]:
        """Return statement, left label and right label of a question.

        Raises `InvalidParameter` if the questionnaire lacks this language.
        """
        cure = "choose one of these languages on the bench, or add texts in this language"
        expected = f"texts in one of {', '.join(question.words)}; {cure}"
        has_words = self.language in question.words
        expect(has_words, f"item {question.item!r}", f"no texts in {self.language!r}", expected)
        return question.words[self.language]

    def message(self, name: str, values: Mapping[str, str | int | float] | None = None) -> str:
        """Return the text of a message, filled in with `values`.

        Raises `InvalidParameter` if the message does not exist, or lacks a value and has no shipped fallback.
        """
        if name not in self.messages:
            raise InvalidParameter(
                f"message {name!r}: found no text of this name, expected a name from the study's texts or from {LIST}"
                f"{nearest(name, self.messages, N_NEAREST)}"
            )
        try:
            return _fill_in(name, self.messages[name], values or {})
        except InvalidParameter:
            if self.messages[name] == self.shipped.get(name, self.messages[name]):
                raise
            return _fill_in(name, self.shipped[name], values or {})

    def page(self, request: Show, left_s: int = 0) -> str:
        """Return the text of a page, filled in.

        It may use the remaining seconds, the stop key, and each length `x_m` also as `x_mm`.
        """
        shown = {name: self.label(value) if isinstance(value, str) else value for name, value in request.values.items()}
        names = {"stop": self.label(self.stop), "experimenter": self.label("experimenter")}
        known = {**_lengths_mm(shown), **shown, "left_s": left_s, **names}
        return self.message(request.message, known)

    def in_language(self, words: Mapping[str, str]) -> str:
        """Return the words in this language, else in English, else nothing."""
        return words.get(self.language, words.get("en", ""))

    def label(self, word: str) -> str:
        """Return a label in this language, or an unknown label unchanged."""
        return self.labels.get(word, word)


def _lengths_mm(values: Mapping[str, str | int | float]) -> dict[str, float]:
    """Convert lengths to millimetres.

    >>> _lengths_mm({"distance_m": 0.028, "block": 2})
    {'distance_mm': 28.0}
    """
    lengths_m = {name: value for name, value in values.items() if name.endswith("_m") and not isinstance(value, str)}
    return {f"{name.removesuffix('_m')}_mm": round(1e3 * length_m, 9) for name, length_m in lengths_m.items()}


def _fill_in(name: str, text: str, values: Mapping[str, str | int | float]) -> str:
    try:
        for _, _, form, _ in string.Formatter().parse(text):
            if form is not None and _WIDE.search(form):
                raise ValueError(f"{form} produces more letters than fit on a page")
        return text.format_map(values)
    except (KeyError, IndexError, ValueError, AttributeError, TypeError) as error:
        raise InvalidParameter(
            f"message {name!r}: found a placeholder that cannot be filled ({error}), expected the names "
            f"{', '.join(sorted(values)) or '(none)'} in braces; for a literal brace write {{{{ and }}}}"
        ) from error


@cache
def _shipped(language: str) -> dict[str, dict[str, str]]:
    one_of("language", language, languages())
    tables = tomllib.loads((FOLDER / f"{PREFIX}{language}{SUFFIX}").read_text("utf-8"))
    return {name: tables[name] for name in ("messages", "labels", "console")}


def phrases_in(language: str) -> Mapping[str, str]:
    """Return the texts of the experimenter's terminal by name, in one language.

    >>> phrases_in("fr")["press"].format(force_n=1.0, duration_s=0.5)
    'appuyez avec 1 N pendant 0.5 s'
    """
    return _shipped(language)["console"]


def reason_words(reason: str) -> str:
    """Return the English description of the reason why a trial is invalid."""
    return phrases_in("en")[reason]


def texts_in(language: str, study: Mapping[str, str]) -> Texts:
    """Return the shipped texts of a language, overridden by those of a study.

    >>> texts_in("fr", {"welcome": "Bonjour {code}"}).message("welcome", {"code": "P01"})
    'Bonjour P01'
    >>> texts_in("fr", {}).label("yes")
    'oui'
    """
    shipped = _shipped(language)
    labels = shipped["labels"] | {name: text for name, text in study.items() if name not in shipped["messages"]}
    return Texts({**shipped["messages"], **study}, labels, language, shipped["messages"])
