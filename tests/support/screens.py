"""All pages of the participant."""

from tactometry.experiments.bench.calibration import BAR_PART, BAR_WORDS
from tactometry.protocols.tasks.rating import pages
from tactometry.questionnaire import load, load_choices
from tactometry.rigs.pages import entry, form, layout
from tactometry.rigs.texts import languages, texts_in
from tactometry.session.request import MISSED_LABELS

FORMS = (("attrakdiff", "fr"), ("attrakdiff", "en"), ("sus", "en"), ("nasa-tlx", "en"), ("pleasantness-vas", "en"))

LEFT = (
    *("welcome", "instructions_yes_no", "instructions_forced_choice", "block", "questions", "questions_first"),
    *("consent", "declined", "practice", "rest", "dry_run_held", "dry_run_lost", "end"),
)
"""Messages that the participant leaves by a key."""
TIMED = ("key_test", "resting", "pause", "stopped")


def message_pages(texts, aspect):
    values = {"block": 2, "n_blocks": 21, "part": 2, "n_parts": 21, "n_questions": 28, "n_keys": 3, "left_s": 25}
    values |= {"stop": texts.label("escape"), "experimenter": texts.label("experimenter"), "within_s": 10.0}
    hint = texts.message("hint_continue")
    left = {name: layout.message_page(texts.message(name, values), hint, aspect) for name in LEFT}
    timed = {name: layout.message_page(texts.message(name, values), "", aspect) for name in TIMED}
    return left | timed | {"block": layout.message_page(texts.message("block", values), hint, aspect, progress=1 / 21)}


def picture_pages(texts, aspect):
    def page(words, **shown):
        parts = layout.parts_of(**shown)
        meanings = {part: texts.message(f"meaning_{part}") for part in parts}
        return layout.picture_page(texts.message(words), meanings, texts.message("hint_continue"), aspect)

    return {
        "how_press_alone": page("how_press", slides=False, force=False, place=False),
        "how_press": page("how_press", slides=False, force=True, place=True),
        "how_slide": page("how_slide", slides=True, force=True, place=True),
    }


def question_pages(texts, aspect):
    def page(question, *labels):
        options = tuple(range(len(labels))) if question == "felt" else tuple(range(1, len(labels) + 1))
        return layout.question_page(texts.message(question), options, labels, texts.message("hint_choose"), aspect)

    def about(page_of):
        item = load_choices("demographics").items[0]
        labels = [item.category(code, texts.language) or texts.label("prefer_not") for code in item.codes]
        return page_of(item.prompt[texts.language], item.codes, labels, texts.message("hint_choose"), aspect)

    return {
        "felt": page("felt", texts.label("no"), texts.label("yes")),
        "about": about(layout.list_page),
        "which": page("which_interval", "1", "2"),
        "which_of_four": page("which_interval", "1", "2", "3", "4"),
        "same": page("same_different", texts.label("same"), texts.label("different")),
        "practice_missed": page("practice_missed", *map(texts.label, MISSED_LABELS.values())),
    }


def marker_pages(texts):
    press, slide = texts.message("press_force"), texts.message("slide_force")
    why = texts.message("lost_too_light")
    low = layout.force_page(layout.marker_page(2, playing=False, words=press, why=why), 0.6, 1.0, 0.2)
    held = layout.force_page(layout.marker_page(2, playing=True, words=slide), 1.1, 1.0, 0.2)
    return {
        "ready": layout.marker_page(1, playing=False, words=texts.message("press")),
        "playing": layout.marker_page(None, playing=True, words=texts.message("slide")),
        "force_low": low,
        "force_held": layout.track_page(held, 0.4, 1 / 3, finger=0.2),
        "waiting": layout.waiting_page(),
    }


def all_pages(language, aspect):
    texts = texts_in(language, {})
    return (
        message_pages(texts, aspect)
        | picture_pages(texts, aspect)
        | question_pages(texts, aspect)
        | {"adjust": layout.adjust_page(texts.message("adjust"), texts.message("hint_adjust"), aspect)}
        | marker_pages(texts)
    )


def form_pages(name, language, aspect):
    loaded = load(name)
    page = pages(loaded, loaded.items)[-1]
    drawn = form.Form(page, texts_in(language, {}))
    left = (None,) * (len(page.questions) - 1)
    marked = [form.Marks((place, *left), row=min(1, len(left)), warned=name == "sus") for place in (2, 3)]
    return [form.form_page(drawn, marks, aspect) for marks in marked]


def other_pages(aspect):
    """Return forms, a number and the bar by name."""
    texts = texts_in("en", {})
    found = {f"form_{name}_{language}": form_pages(name, language, aspect)[0] for name, language in FORMS}
    how_strong, hint = texts.message("how_strong"), texts.message("hint_enter")
    found["entry"] = entry.entry_page(how_strong, "12.5", hint, aspect, ready=True)
    return found | {"bar": layout.bar_page(BAR_WORDS, texts.message("hint_continue"), aspect, BAR_PART)}


def every_page(aspect):
    """Return all pages by name, in every language."""
    found = {f"{lang}_{name}": page for lang in languages() for name, page in all_pages(lang, aspect).items()}
    return found | other_pages(aspect)
