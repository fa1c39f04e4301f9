"""Texts and questionnaires checked before the first page."""

import io
import re

import pytest
from command_line import call, refused
from own_form import OWN_FORM
from short_studies import shortened
from study_texts import TUTORIAL as CONSTANT_TUTORIAL

from tactometry.errors import InvalidParameter
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.rehearsal import rehearse
from tactometry.experiments.study.study_file import builtin, parse
from tactometry.rigs.texts import languages

TUTORIAL = CONSTANT_TUTORIAL.replace("repeats = 4", "repeats = 1")
BLOCK = '[texts]\nblock = "{frequency_hz:.1f} Hz"\n'
FLAWS = {
    "unknown place": (
        '[texts]\nend = "{nope}"\n',
        "texts: message 'end': found a placeholder that cannot be filled ('nope')",
    ),
    "open brace": ('[texts]\nend = "{"\n', "texts: message 'end': found a placeholder that cannot be filled"),
    "wide number": (
        '[texts]\nwelcome = "{n_blocks:99999999999999}"\n',
        "texts: message 'welcome': found a placeholder that cannot be filled (99999999999999 produces more letters",
    ),
    "place of another page": (
        '[texts]\nfelt = "{block}?"\n',
        "texts: message 'felt': found a placeholder that cannot be",
    ),
    "page within a block": (
        '[texts]\nrest = "{block}"\n',
        "texts: message 'rest': found a placeholder that cannot be filled",
    ),
    "no such text": ('[texts]\nende = "Bye"\n', "texts.ende: found a text that no page shows, expected a name in"),
    "no such text in a translation": (
        '[translations.fr]\nende = "Fin"\n',
        "translations.fr.ende: found a text that no page shows, expected a name in",
    ),
    "unknown place in a translation": (
        '[translations.fr]\nend = "{nope}"\n',
        "translations.fr: message 'end': found a placeholder that cannot be filled ('nope')",
    ),
    "unknown language": ('[translations.xx]\nend = "Fin"\n', "translations.xx: language: found 'xx', expected"),
    "language of a prompt that is not there": (
        '[inquiries.end]\nform = "sus"\nprompt = { en = "It was", xx = "Es" }\n',
        "inquiries.end.prompt: language: found 'xx', expected one of",
    ),
    "number on a questionnaire's page": (
        '[texts]\nquestions = "{frequency_hz:.1f}"\n[inquiries.end]\nform = "sus"\n',
        "texts: message 'questions': found a placeholder that cannot be filled (Unknown format code 'f'",
    ),
    "factor that is interleaved": (
        f'{BLOCK}[plan]\ninterleave = ["frequency_hz"]\n',
        "texts: message 'block': found a placeholder that cannot be filled ('frequency_hz')",
    ),
}
SOUND = {
    "places of a part": BLOCK,
    "seconds that are left": '[texts]\nresting = "{left_s} s"\nend = "{left_s}"\nyes = "si"\nfelt = "Alors {{?}}"\n',
    "a language beside": '[texts]\nend = "Bye"\n[translations.fr]\nend = "Fin"\n',
    "a questionnaire beside": f'{BLOCK}[inquiries.end]\nform = "sus"\n',
    "one part alone": '[texts]\ninstructions_rating = "Rate it"\n',
}


def written(tmp_path, more):
    path = tmp_path / "s.toml"
    path.write_text(f"{TUTORIAL}\n{more}", "utf-8")
    return path


@pytest.mark.parametrize("flaw", FLAWS)
@pytest.mark.parametrize("command", ["dry run", "run", "simulate"])
def test_unfillable_text_is_refused_before_the_session(tmp_path, capsys, flaw, command):
    more, message = FLAWS[flaw]
    path = written(tmp_path, more)
    words = {
        "dry run": ["run", path, "--participant", "P01", "--rig", "simulated", "--dry-run"],
        "run": ["run", path, "--participant", "P01", "--rig", "simulated", "--out", tmp_path / "d"],
        "simulate": ["simulate", path, "--participants", 2, "--seed", 1, "--out", tmp_path / "d"],
    }
    status, said, out = call(capsys, *words[command])
    assert (status, out) == (2, "")
    assert said.startswith(f"tactometry: {path}, {message}")
    assert [each.name for each in tmp_path.iterdir()] == ["s.toml"]


def test_unknown_text_lists_nearest_names_only(tmp_path, capsys):
    path = written(tmp_path, '[texts]\nhint_chose = "A key"\n')
    _, said, _ = call(capsys, "run", path, "--participant", "P01", "--rig", "simulated", "--dry-run")
    assert said.endswith("or a textual level; did you mean 'hint_choose' or 'hint_continue' or 'hint_end'?")
    assert len(said) < 300 + len(str(path))


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ('rest_s = "1 min"', "task.rest_s: found 60 s without rest_after, expected rest_after or rest_every_s too"),
        ('interleaving = "balanced"', "task.interleaving: found 'balanced' without interleaved tracks"),
        ("catch_rate = 5e-324", "task.catch_rate: found 4.94066e-324, expected 0, or at least 1e-06"),
    ],
)
def test_key_without_effect_is_refused(tmp_path, capsys, key, message):
    path = tmp_path / "s.toml"
    path.write_text(TUTORIAL.replace("catch_rate = 0.2", key), "utf-8")
    said = refused(capsys, "run", path, "--participant", "P01", "--dry-run")
    assert said.startswith(f"tactometry: {path}, {message}")


@pytest.mark.parametrize("key", ["title", "description"])
def test_study_without_title_or_description_is_refused(tmp_path, capsys, key):
    path = tmp_path / "s.toml"
    path.write_text(re.sub(rf'{key} = ".*"', f'{key} = ""', TUTORIAL), "utf-8")
    said = refused(capsys, "simulate", path, "--participants", 1, "--seed", 1, "--out", tmp_path / "d")
    assert f"{key}: found nothing, expected a text" in said
    assert not (tmp_path / "d").exists()


@pytest.mark.parametrize("sound", SOUND)
def test_texts_that_can_be_shown_are_taken(sound):
    rehearse(wire(parse(f"{TUTORIAL}\n{SOUND[sound]}".encode(), "s.toml"), "s.toml"))


def test_every_group_and_session_is_tried():
    """The last level of a factor between participants is a text."""
    study = TUTORIAL.replace("[factors]\nfrequency_hz = [60, 240]", '[factors]\npace = ["slow", 3.5]')
    for place in ("between", "sessions"):
        more = (
            f'[plan]\n{place} = ["pace"]\n[variants.pace.slow]\n[variants.pace."3.5"]\n[texts]\nblock = "{{pace:s}}"\n'
        )
        content = study.replace('kind = "amplitude_modulated"', 'kind = "amplitude_modulated"\nfrequency_hz = 60.0')
        with pytest.raises(InvalidParameter, match="message 'block': .*Unknown format code 's'"):
            rehearse(wire(parse(f"{content}\n{more}".encode(), "s.toml"), "s.toml"))


@pytest.mark.parametrize(
    ("text", "warning", "is_replaced"),
    [
        (f"{TUTORIAL}\n{FLAWS['unknown place'][0]}", "cannot be filled ('nope')", True),
        (
            TUTORIAL.replace("catch_rate = 0.2", 'rest_s = "1 min"'),
            "expected rest_after or rest_every_s too, as no rest",
            False,
        ),
    ],
)
def test_locked_study_continues_with_a_warning(tmp_path, capsys, monkeypatch, text, warning, is_replaced):
    path, data = tmp_path / "s.toml", tmp_path / "d"
    data.mkdir()
    for file in (path, data / "study.toml"):
        file.write_text(text, "utf-8")
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 30))
    status, said, out = call(capsys, "run", path, "--participant", "P01", "--rig", "console", "--out", data)
    assert status == 0
    assert warning in said
    assert ("the built-in text is shown instead" in said) is is_replaced
    assert "That was all" in out


def test_untranslated_questionnaire_is_refused_before_the_session(tmp_path, capsys):
    path, bench = written(tmp_path, OWN_FORM), tmp_path / "bench.toml"
    bench.write_text('[screen]\nlanguage = "fr"\n', "utf-8")
    words = ["run", path, "--participant", "P01", "--out", tmp_path / "d"]
    for more in (["--rig", "console"], ["--rig", "bench"], ["--dry-run"]):
        said = refused(capsys, *words, "--bench", bench, *more)
        assert "s.toml, questionnaire mine: found no words in 'fr', expected one of en; choose that language" in said
    assert call(capsys, *words, "--bench", bench, "--rig", "simulated")[0] == 0


IN_FRENCH = {
    "time-reversal-localisation": ("Où ?", "repères distants de 28 mm", "2 = majeur, 3 = index + majeur"),
    "force-loss": ("Appuyez avec le contacteur souple de 5 mm en F, à 0.5 N.",),
}
IN_GERMAN = {
    "time-reversal-localisation": ("Wo?", "die 28 mm auseinander liegen", "2 = Mittelfinger, 3 = Zeige + Mittel"),
    "force-loss": ("Drücken Sie mit der weichen Spitze von 5 mm an der Stelle F, mit 0.5 N.",),
}
IN_ENGLISH = {
    "time-reversal-localisation": ("Where?", "marks that are 28 mm apart", "2 = middle, 3 = index + middle"),
    "force-loss": ("Press the soft contactor of 5 mm at F with 0.5 N.",),
}


@pytest.mark.parametrize(("language", "told"), [("fr", IN_FRENCH), ("en", IN_ENGLISH), ("de", IN_GERMAN)])
@pytest.mark.parametrize("name", IN_FRENCH)
def test_session_shows_study_texts_in_language(tmp_path, capsys, monkeypatch, name, language, told):
    (tmp_path / "s.toml").write_text(shortened(name), "utf-8")
    (tmp_path / "bench.toml").write_text(f'[screen]\nlanguage = "{language}"\n', "utf-8")
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 60))
    words = ["run", tmp_path / "s.toml", "--participant", "P01", "--rig", "console", "--bench", tmp_path / "bench.toml"]
    status, said, out = call(capsys, *words, "--out", tmp_path / "d")
    assert status == 0, said
    assert all(each in out for each in told[name]), out


def test_built_in_study_texts_are_translated():
    for path in builtin().values():
        study = parse(path.read_bytes(), path.name)
        for words in study.translations.values():
            assert words.keys() >= study.texts.keys(), path.name
        assert set(study.translations) == ({*languages()} - {"en"} if study.texts else set()), path.name
