"""Texts of the participant's pages, and the words that each must contain in every language."""

import re
import string
from itertools import combinations

import pytest

from tactometry.errors import InvalidParameter
from tactometry.rigs.texts import languages, phrases_in, texts_in
from tactometry.trials.trial import REASONS


def places(text):
    return {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}


@pytest.mark.parametrize("language", languages())
def test_every_language_has_the_same_messages(language):
    english, other = texts_in("en", {}), texts_in(language, {})
    assert sorted(english.labels.keys() ^ other.labels.keys()) == [], f"labels in messages_{language}.toml"
    assert sorted(english.messages.keys() ^ other.messages.keys()) == [], f"messages in messages_{language}.toml"
    in_english, phrases = phrases_in("en"), phrases_in(language)
    assert sorted(in_english.keys() ^ phrases.keys()) == [], f"console in messages_{language}.toml"
    pairs = [(text, english.messages[name]) for name, text in other.messages.items()]
    pairs += [(text, in_english[name]) for name, text in phrases.items()]
    unlike = [text for text, model in pairs if places(text) != places(model)]
    assert unlike == [], f"messages_{language}.toml fills other places in these"


@pytest.mark.parametrize("language", languages())
def test_every_invalid_reason_has_a_message(language):
    messages = {texts_in(language, {}).message(f"lost_{reason}") for reason in REASONS}
    assert len(messages) == len(REASONS)
    assert not messages & {f"lost_{reason}" for reason in REASONS}


@pytest.mark.parametrize(("one", "other", "same"), [("en", "fr", ["right"]), ("en", "de", []), ("de", "fr", [])])
def test_languages_do_not_share_texts(one, other, same):
    first, second = texts_in(one, {}).messages, texts_in(other, {}).messages
    assert [name for name in first if first[name] == second[name]] == same


@pytest.mark.parametrize(
    ("language", "words"),
    [("fr", "tu|te|toi|ton|ta|tes|prêt|prêts|sûr|certain"), ("de", "du|dir|dich|dein|deine|deinen|Teilnehmer|Proband")],
)
def test_texts_are_formal_and_gender_neutral(language, words):
    texts = texts_in(language, {})
    assert [name for name, text in texts.messages.items() if re.search(rf"\b(?:{words})\b", text)] == []


@pytest.mark.parametrize("language", languages())
def test_every_line_fits_on_a_narrow_screen(language):
    """A line fits 70 letters of text or 90 of a hint at 1280 x 800.

    A touch page at 1024 x 768 fits 62.
    """
    for name, text in texts_in(language, {}).messages.items():
        longest = max(map(len, text.splitlines()))
        most = 62 if name.startswith("lost_") else 90 if name.startswith(("hint", "meaning")) else 70
        assert longest <= most, name


def test_study_texts_override_built_in_texts():
    texts = texts_in("fr", {"felt": "Alors ?", "yes": "si"})
    assert (texts.message("felt"), texts.label("yes"), texts.label("no")) == ("Alors ?", "si", "non")
    assert texts.label("rugueux") == "rugueux"


@pytest.mark.parametrize(
    ("name", "texts", "values", "message"),
    [
        ("welcom", {}, {}, r"message 'welcom': found no text of this name, .*did you mean 'welcome'\?"),
        ("block", {}, {"part": 1}, r"message 'block': .*\('n_parts'\), expected the names part in braces"),
        ("mine", {"mine": "{0}"}, {}, r"message 'mine': .*expected the names \(none\) in braces"),
        ("mine", {"mine": "{"}, {}, "message 'mine': found a placeholder that cannot be filled"),
        ("mine", {"mine": "{a.b}"}, {"a": 1}, "message 'mine': found a placeholder that cannot be filled"),
    ],
)
def test_invalid_messages_are_rejected(name, texts, values, message):
    with pytest.raises(InvalidParameter, match=message):
        texts_in("en", texts).message(name, values)


def test_an_unknown_language_is_refused():
    with pytest.raises(InvalidParameter, match="language: found 'fl', expected one of de, en, fr"):
        texts_in("fl", {})


COLUMNS = ("en", "de", "fr")
TABLE = """
welcome             | welcome finger stop            | willkommen finger aufhören         | bienvenue doigt arrêter
instructions_yes_no | sometimes nothing whether      | manchmal nichts ob                 | parfois rien si
instructions_forced_choice | first only guess        | erste nur raten                    | premier seul hasard
instructions_same_different | same different both    | gleich verschieden beide           | identiques différents deux
instructions_comparison | stronger twice guess       | stärker zweimal raten              | forte deux devinez
instructions_magnitude | number strong 0             | zahl stark 0                       | nombre forte 0
instructions_localisation | where place which        | wo stelle welche                   | où endroit lequel
instructions_preference | prefer which twice         | lieber was zweimal                 | préférez laquelle deux
instructions_adjustment | change confirm yourself    | verändern bestätigen selbst        | changez confirmez régler
instructions_rating | feel first questions wrong     | fühlen zuerst fragen falschen      | touchez d'abord questions
questions           | questions follow wrong         | folgen fragen falschen             | questions suivent mauvaise
instructions_measurement | read vibrometer contactor | lesen vibrometer kontaktstift      | lisez vibromètre contacteur
block               | part ready time                | teil bereit zeit                   | partie temps commencez
consent             | free stop code name            | freiwillig aufhören code namen     | librement arrêter code nom
declined            | thank nothing call             | danke nichts rufen                 | merci rien appelez
agree               | want part                      | möchten teilnehmen                 | voulez participer
questions_first     | before questions open          | bevor fragen offen                 | avant questions réponse
practice            | practice not count             | übung nicht zählen                 | entraînement pas comptent
practice_missed     | practice over call             | übung ende rufen                   | entraînement fini appelez
again               | again                          | nochmals                           | encore
go_on               | go on                          | weiter                             | continuer
end_session         | end                            | beenden                            | finir
rest                | rest lift ready                | pause heben bereit                 | pause levez voulez
pause               | pause lift moment              | pause heben gleich                 | pause levez instant
resting             | rest lift {left_s}             | pause heben {left_s}               | pause levez {left_s}
stopped             | stopped kept call              | angehalten gesichert rufen         | arrêt conservées appelez
dry_run_held        | done now begins                | gemacht jetzt los                  | bien maintenant commence
dry_run_lost        | practice unclear ask begins    | übung unklar rufen los             | habitude clair demandez
end                 | all thank lift                 | alles dank heben                   | terminé merci lever
felt                | did feel something             | haben etwas gespürt                | senti quelque chose
which_interval      | which interval                 | welchem intervall                  | quel intervalle
adjust              | change until right             | verändern bis stimmt               | changez jusqu'à convienne
press               | press still                    | drücken still                      | appuyez immobile
release             | lift then press again          | heben dann wieder                  | levez puis nouveau
press_force         | press bar between lines        | drücken balken zwischen linien     | appuyez barre entre traits
slide               | follow dot finger              | folgen punkt finger                | suivez doigt point
slide_force         | follow dot bar between         | folgen punkt balken zwischen       | suivez point barre entre
lost_too_light      | light: more bar                | leicht: mehr balken                | léger : plus barre
lost_too_heavy      | heavy: less bar                | stark: weniger balken              | fort : moins barre
lost_stopped        | stopped: keep sliding          | still: gleiten                     | arrêté : glissez
lost_too_slow       | slow: dot                      | langsam: punkt                     | lent : point
lost_too_fast       | fast: dot not before           | schnell: punkt nicht davor         | rapide : point pas devant
lost_lifted         | left: keep touching            | abgehoben: liegen                  | levé : gardez posé
lost_timeout        | not light up                   | nicht an:                          | pas allumé :
lost_sensor_lost    | sensor lost once more          | sensor verloren noch einmal        | perdu capteur encore
lost_output_gap     | device not you once more       | gerät nicht ihnen noch einmal      | défaut appareil encore
lost_experimenter   | once more                      | noch einmal                        | encore fois
how_press           | how press                      | so drücken                         | comment appuyer
how_slide           | how slide                      | so gleiten                         | comment glisser
meaning_circle      | circle: filled touching        | kreis: gefüllt liegen              | cercle : plein levez
meaning_bar         | bar: press between             | balken: kraft zwischen             | barre : force entre
meaning_dot         | dot: follow fro                | punkt: folgen zurück               | point : suivez retour
meaning_ring        | ring: around dot               | ring: um punkt                     | anneau : autour point
dry_run             | try nothing yet                | versuchen noch nichts              | essayez encore rien
hint_end            | space bar finish               | leertaste beenden                  | espace terminer
hint_continue       | space bar go on                | leertaste weiter                   | espace continuer
hint_choose         | key box                        | taste feld                         | touche case
hint_adjust         | arrow + − ok                   | pfeiltasten + − ok                 | flèches + − ok
right               | correct                        | richtig                            | correct
wrong               | wrong                          | falsch                             | faux
same_different      | both same                      | beides gleich                      | deux identiques
which_stronger      | which stronger                 | was stärker                        | laquelle forte
which_place         | where feel                     | wo gespürt                         | où senti
which_preferred     | which prefer                   | was lieber                         | laquelle préférez
how_strong          | how strong                     | wie stark                          | intensité
vibrometer_nm       | amplitude vibrometer nm        | amplitude vibrometer nm            | amplitude vibromètre nm
hint_enter          | type number ok                 | zahl tippen ok                     | tapez nombre ok
hint_fill           | number arrow place ok          | ziffern pfeiltasten stelle ok      | chiffres flèches place ok
hint_fill_arrows    | arrow place ok                 | pfeiltasten stelle ok              | flèches place ok
key_test            | keyboard space {n_keys}        | tastatur leertaste {n_keys}        | clavier espace {n_keys}
hint_fill_line      | home end draw                  | pos1 ende ziehen                   | début fin glissez
page_count          | page of                        | seite von                          | page sur
page_back           | back                           | zurück                             | retour
leave_open          | 0 leave open                   | 0 offen lassen                     | 0 laisser vide
hint_gaps           | some open answer 0             | einige offen beantworten 0         | reste ouvertes répondez 0
no                  | no                             | nein                               | non
yes                 | yes                            | ja                                 | oui
say_number          | enter number                   | zahl eingeben                      | saisir nombre
prefer_not          | prefer not                     | keine angabe                       | préfère ne pas
first               | first                          | erste                              | premier
second              | second                         | zweite                             | second
same                | same                           | gleich                             | identique
different           | different                      | verschieden                        | différent
experimenter        | experimenter                   | versuchsleitung                    | mène étude
escape              | escape                         | escape                             | échap
ctrl_c              | ctrl-c                         | strg-c                             | ctrl-c
"""
ROWS = [[cell.strip() for cell in line.split("|")] for line in TABLE.strip().splitlines()]
HELD = {language: {name: words[n].split() for name, *words in ROWS} for n, language in enumerate(COLUMNS)}
ALONE = ("no", "yes", "right", "wrong", "same", "different")
"""Texts that consist of exactly their word."""


def said_in(language):
    texts = texts_in(language, {})
    return {**texts.messages, **texts.labels}


def lacks(language, name, text):
    wanted, text = HELD[language][name], text.casefold()
    if name in ALONE:
        return [] if [text] == wanted else wanted
    return [word for word in wanted if word not in text]


def test_word_table_covers_every_language_and_text():
    assert sorted(COLUMNS) == sorted(languages()), "add a column of words for each language"
    for language in COLUMNS:
        assert sorted(HELD[language].keys() ^ said_in(language).keys()) == [], "add a row of words for each text"


@pytest.mark.parametrize("language", COLUMNS)
def test_each_text_contains_its_words(language):
    said = said_in(language)
    assert {name: words for name in said if (words := lacks(language, name, said[name]))} == {}


@pytest.mark.parametrize("language", COLUMNS)
def test_word_table_distinguishes_all_texts(language):
    """Swapped texts, such as yes and no, must violate the table."""
    said = said_in(language)
    alike = [
        (one, other)
        for one, other in combinations(said, 2)
        if not lacks(language, one, said[other]) and not lacks(language, other, said[one])
    ]
    assert alike == []
