"""Texts and questionnaires checked before the first page."""

import io

import pytest
from command_line import call, refused
from own_form import OWN_FORM
from short_studies import shortened
from study_texts import TUTORIAL as CONSTANT_TUTORIAL, changed, wired

from tactometry.errors import InvalidParameter
from tactometry.experiments.study.rehearsal import rehearse
from tactometry.experiments.study.study_file import builtin, parse
from tactometry.rigs.texts import languages

TUTORIAL = CONSTANT_TUTORIAL.replace("repeats = 4", "repeats = 1")
BLOCK = '[texts]\nblock = "{frequency_hz:.1f} Hz"\n'
UNFILLED = "found a placeholder that cannot be filled"
FLAWS = [
    ('[texts]\nend = "{nope}"\n', f"texts: message 'end': {UNFILLED} ('nope')"),
    ('[texts]\nend = "{"\n', f"texts: message 'end': {UNFILLED}"),
    (
        '[texts]\nwelcome = "{n_blocks:99999999999999}"\n',
        f"texts: message 'welcome': {UNFILLED} (99999999999999 produces more letters",
    ),
    ('[texts]\nfelt = "{block}?"\n', f"texts: message 'felt': {UNFILLED}"),
    ('[texts]\nrest = "{block}"\n', f"texts: message 'rest': {UNFILLED}"),
    ('[texts]\nende = "Bye"\n', "texts.ende: found a text that no page shows, expected a name in"),
    ('[translations.fr]\nende = "Fin"\n', "translations.fr.ende: found a text that no page shows, expected a name in"),
    ('[translations.fr]\nend = "{nope}"\n', f"translations.fr: message 'end': {UNFILLED} ('nope')"),
    ('[translations.xx]\nend = "Fin"\n', "translations.xx: language: found 'xx', expected"),
    (
        '[inquiries.end]\nform = "sus"\nprompt = { en = "It was", xx = "Es" }\n',
        "inquiries.end.prompt: language: found 'xx', expected one of",
    ),
    (
        '[texts]\nquestions = "{frequency_hz:.1f}"\n[inquiries.end]\nform = "sus"\n',
        f"texts: message 'questions': {UNFILLED} (Unknown format code 'f'",
    ),
    (f'{BLOCK}[plan]\ninterleave = ["frequency_hz"]\n', f"texts: message 'block': {UNFILLED} ('frequency_hz')"),
]
SOUND = [
    BLOCK,
    '[texts]\nresting = "{left_s} s"\nend = "{left_s}"\nyes = "si"\nfelt = "Alors {{?}}"\n',
    '[texts]\nend = "Bye"\n[translations.fr]\nend = "Fin"\n',
    f'{BLOCK}[inquiries.end]\nform = "sus"\n',
    '[texts]\ninstructions_rating = "Rate it"\n',
]


def written(tmp_path, more):
    path = tmp_path / "s.toml"
    path.write_text(f"{TUTORIAL}\n{more}", "utf-8")
    return path


@pytest.mark.parametrize(("more", "message"), FLAWS)
@pytest.mark.parametrize("command", ["dry run", "run", "simulate"])
def test_unfillable_text_is_refused_before_the_session(tmp_path, capsys, more, message, command):
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


@pytest.mark.parametrize("more", SOUND)
def test_texts_that_can_be_shown_are_taken(more):
    rehearse(wired(f"{TUTORIAL}\n{more}"))


def test_every_group_and_session_is_tried():
    """The last level of a factor between participants is a text."""
    kind = '"amplitude_modulated"'
    changes = {"frequency_hz = [60, 240]": 'pace = ["slow", 3.5]', kind: f"{kind}\nfrequency_hz = 60.0"}
    more = '[variants.pace.slow]\n[variants.pace."3.5"]\n[texts]\nblock = "{pace:s}"\n'
    for place in ("between", "sessions"):
        study = wired(f'{changed(TUTORIAL, changes)}\n[plan]\n{place} = ["pace"]\n{more}')
        with pytest.raises(InvalidParameter, match="message 'block': .*Unknown format code 's'"):
            rehearse(study)


@pytest.mark.parametrize(
    ("text", "warning", "is_replaced"),
    [
        (f"{TUTORIAL}\n{FLAWS[0][0]}", "cannot be filled ('nope')", True),
        (TUTORIAL.replace("catch_rate = 0.2", 'rest_s = "1 min"'), "expected rest_after or rest_every_s too", False),
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


SHOWN = [
    ("time-reversal-localisation", "fr", ("Où ?", "repères distants de 28 mm", "2 = majeur, 3 = index + majeur")),
    ("time-reversal-localisation", "de", ("Wo?", "die 28 mm auseinander", "2 = Mittelfinger, 3 = Zeige + Mittel")),
    ("time-reversal-localisation", "en", ("Where?", "marks that are 28 mm apart", "2 = middle, 3 = index + middle")),
    ("force-loss", "fr", ("Appuyez avec le contacteur souple de 5 mm en F, à 0.5 N.",)),
    ("force-loss", "de", ("Drücken Sie mit der weichen Spitze von 5 mm an der Stelle F, mit 0.5 N.",)),
    ("force-loss", "en", ("Press the soft contactor of 5 mm at F with 0.5 N.",)),
]


@pytest.mark.parametrize(("name", "language", "texts"), SHOWN)
def test_session_shows_study_texts_in_language(tmp_path, capsys, monkeypatch, name, language, texts):
    (tmp_path / "s.toml").write_text(shortened(name), "utf-8")
    (tmp_path / "bench.toml").write_text(f'[screen]\nlanguage = "{language}"\n', "utf-8")
    monkeypatch.setattr("sys.stdin", io.StringIO("1\n" * 60))
    words = ["run", tmp_path / "s.toml", "--participant", "P01", "--rig", "console", "--bench", tmp_path / "bench.toml"]
    status, said, out = call(capsys, *words, "--out", tmp_path / "d")
    assert status == 0, said
    assert all(each in out for each in texts), out


def test_built_in_study_texts_are_translated():
    for path in builtin().values():
        study = parse(path.read_bytes(), path.name)
        for words in study.translations.values():
            assert words.keys() >= study.texts.keys(), path.name
        assert set(study.translations) == ({*languages()} - {"en"} if study.texts else set()), path.name
