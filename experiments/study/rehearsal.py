"""Check a study's texts, prompts and images on all pages."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import prod
from pathlib import Path

from tactometry.arguments.require import expect, one_of
from tactometry.errors import InvalidParameter, nearest, rewording
from tactometry.protocols.session import pages
from tactometry.questionnaire import ChoiceForm, Questionnaire
from tactometry.rigs.texts import LIST, N_NEAREST, PageImage, Texts, image_of, languages, texts_in
from tactometry.session.request import Show

from .experiment import Experiment
from .session_plan import all_sessions, stream
from .study import by_language

WITHIN_BLOCKS = frozenset(("rest", "resting", "right", "wrong", "consent", "declined", "practice_missed"))
"""Messages of pages within a block, for consent, and after a missed practice criterion."""


def rehearse(experiment: Experiment) -> None:
    """Reject keys without effect, and check all texts of a study.

    Raises `InvalidParameter` if a key of the task has no effect, or a text has an unknown name or its placeholders
    cannot be filled in.
    """
    study = experiment.study
    with rewording(lambda words: f"{experiment.where}, {words}"):
        _refuse_idle(experiment)
        shown = {page.message for page in _pages(experiment)} | WITHIN_BLOCKS if study.images else set()
        for name in study.images:
            one_of("images", name, sorted(shown))
        _rehearse_texts(experiment, "texts", study.texts, study.texts, "en")
        for where, prompt in _prompts(experiment).items():
            for language in prompt:
                one_of(f"{where}: language", language, languages())
        for language, words in study.translations.items():
            _rehearse_texts(experiment, f"translations.{language}", words, study.words_in(language), language)


def _rehearse_texts(
    experiment: Experiment, where: str, own: Mapping[str, str], words: Mapping[str, str], language: str
) -> None:
    """Check that each custom text has a page and valid placeholders."""
    with rewording(lambda said: f"{where}: {said}"):
        texts = replace(texts_in(language, words), shipped={})  # a built-in text must not hide an invalid one
    known = texts_in(language, {})
    levels = {level for levels in experiment.study.factors.values() for level in levels if isinstance(level, str)}
    names = sorted({*known.messages, *known.labels, *levels})
    for name in own:
        expected = f"a name in {LIST}, or a textual level{nearest(name, names, N_NEAREST)}"
        expect(name in names, f"{where}.{name}", "a text that no page shows", expected)
    shown = set()
    for page in _pages(experiment) if own else ():
        shown.add(page.message)
        _fill(texts, page, where)
    for name in own:
        if name in known.messages and name not in shown:
            is_page = name in WITHIN_BLOCKS or name.startswith("instructions_")
            _fill(texts, Show(name) if is_page else name, where)


def _prompts(experiment: Experiment) -> dict[str, dict[str, str]]:
    inquiries = {f"inquiries.{name}.prompt": of.prompt for name, of in experiment.study.inquiries.items()}
    prompts = {"task.prompt": experiment.table.prompt} | inquiries
    return {where: by_language(prompt) for where, prompt in prompts.items() if prompt}


def _refuse_idle(experiment: Experiment) -> None:
    options, study = experiment.table.options, experiment.study
    for name in ("title", "description"):
        is_text = bool(getattr(study, name).strip())
        expect(is_text, name, "nothing", "a text, used in the description of the data set")
    if options.rest_s is not None:
        alone = f"{options.rest_s:g} s without rest_after"
        comes = options.rest_after is not None or options.rest_every_s is not None
        expect(comes, "task.rest_s", alone, "rest_after or rest_every_s too, as no rest occurs")
    has_tracks = bool(study.plan.interleave) or experiment.table.task_kind.n_together is not None
    idle = f"{options.interleaving!r} without interleaved tracks"
    has_effect = options.interleaving == "random" or has_tracks
    expect(has_effect, "task.interleaving", idle, "factors in plan.interleave; or remove the key")


def _pages(experiment: Experiment) -> Iterator[Show]:
    study = experiment.study
    for number in range(1, prod(len(study.factors[name]) for name in study.plan.between) + 1):
        n_sessions = len(all_sessions(study, experiment.table.over, number, 0)) if study.plan.sessions else 1
        for n_session in range(1, n_sessions + 1):
            yield from pages(experiment.parts(number, stream(0, "rehearsal"), n_session))


def _fill(texts: Texts, shown: Show | str, where: str) -> None:
    with rewording(lambda words: f"{where}: {words}"):
        texts.page(shown) if isinstance(shown, Show) else texts.message(shown)


def page_images(experiment: Experiment) -> dict[str, PageImage]:
    """Check the images of a window's pages, and return them by message.

    Raises `InvalidParameter` if a file is missing, differs from the stated digest, or is not an image.
    """
    study = experiment.study
    located = {name: replace(table, path=study.beside(table.path)) for name, table in study.images.items()}
    with rewording(lambda words: f"{experiment.where}, {words}"):
        return {name: image_of(table, f"images.{name}") for name, table in located.items()}


def rehearse_forms(experiment: Experiment, language: str) -> None:
    """Check that all items and prompts have texts in the language of a rig.

    Raises `InvalidParameter` if a questionnaire has no texts in this language, or a prompt has none in it or in
    English.
    """
    shown: tuple[Questionnaire | ChoiceForm, ...] = (*experiment.questionnaires, *experiment.choices)
    forms = {f"questionnaire {form.name}": (form.languages, language in form.languages) for form in shown}
    prompts = {where: (words, language in words or "en" in words) for where, words in _prompts(experiment).items()}
    for where, (known, has_words) in (prompts | forms).items():
        expected = f"one of {', '.join(known)}; choose that language on the bench, or add the words"
        expect(has_words, f"{experiment.where}, {where}", f"no words in {language!r}", expected)


def flaw(experiment: Experiment, root: Path) -> str | None:
    """Return an error in the texts of a study that already has sessions.

    Raises `InvalidParameter` as for `rehearse`, before the first session.
    """
    try:
        rehearse(experiment)
    except InvalidParameter as error:
        if not (root / "study.toml").exists():
            raise
        is_text = str(error).startswith((f"{experiment.where}, texts: ", f"{experiment.where}, translations."))
        return f"{error}{'; the built-in text is shown instead' if is_text else ''}"
    return None
