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
    """A failure lists the missing and the superfluous messages."""
    english, other = texts_in("en", {}), texts_in(language, {})
    assert sorted(english.labels.keys() ^ other.labels.keys()) == [], f"labels in messages_{language}.toml"
    assert sorted(english.messages.keys() ^ other.messages.keys()) == [], f"messages in messages_{language}.toml"
    told, said = phrases_in("en"), phrases_in(language)
    assert sorted(told.keys() ^ said.keys()) == [], f"console in messages_{language}.toml"
    pairs = [(text, english.messages[name]) for name, text in other.messages.items()]
    pairs += [(text, told[name]) for name, text in said.items()]
    unlike = [text for text, in_english in pairs if places(text) != places(in_english)]
    assert unlike == [], f"messages_{language}.toml fills other places in these"


@pytest.mark.parametrize("language", languages())
def test_every_invalid_reason_has_a_message(language):
    told = [texts_in(language, {}).message(f"lost_{reason}") for reason in REASONS]
    assert len(set(told)) == len(REASONS)
    assert not set(told) & {f"lost_{reason}" for reason in REASONS}


@pytest.mark.parametrize(("one", "other", "same"), [("en", "fr", ["right"]), ("en", "de", []), ("de", "fr", [])])
def test_languages_do_not_share_texts(one, other, same):
    first, second = texts_in(one, {}).messages, texts_in(other, {}).messages
    assert [name for name in first if first[name] == second[name]] == same


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("fr", "tu|te|toi|ton|ta|tes|prêt|prêts|sûr|certain"),
        ("de", "du|dir|dich|dein|deine|deinen|Teilnehmer|Proband"),
    ],
)
def test_texts_are_formal_and_gender_neutral(language, words):
    texts = texts_in(language, {})
    found = {name: re.findall(rf"\b(?:{words})\b", text) for name, text in texts.messages.items()}
    assert {name: told for name, told in found.items() if told} == {}


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


def test_untranslated_label_is_unchanged():
    assert texts_in("fr", {}).label("rugueux") == "rugueux"


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
console.plays       | play through {output}          | werden über {output}               | passent par {output}
console.silent      | nothing study --bench          | nichts studie --bench              | rien étude --bench
console.stopping    | stops ctrl-d safe              | hält strg-d sicher                 | arrête ctrl-d sûreté
console.go_on       | return continue                | weiter eingabetaste                | entrée continuer
console.no_answer   | expected {expected} {line}     | erwartet {expected} {line}         | attendue {expected} {line}
console.trial       | trial                          | durchgang                          | essai
console.interval    | interval                       | intervall                          | intervalle
console.play        | play {duration_s:g} s          | spielt {duration_s:g} s            | émission {duration_s:g} s
console.press       | press {force_n:g} n            | drücken {force_n:g} n              | appuyez {force_n:g} n
console.slide       | slide {force_n:g} n mm/s       | gleiten {force_n:g} n mm/s         | glissez {force_n:g} n mm/s
console.lift        | lift first                     | zuerst heben                       | levez d'abord
console.number      | number from to                 | zahl von bis                       | nombre de à
console.number_from | number from                    | zahl ab                            | nombre partir
console.either      | {options} or {last}            | {options} oder {last}              | {options} ou {last}
console.steps       | steps                          | schritten                          | pas de
console.ways        | - leaves < back                | - lässt < zurück                   | - laisse < arrière
console.level       | level                          | pegel                              | niveau
console.valid       | valid                          | zählt                              | compte
console.not_valid   | not valid                      | zählt nicht                        | compte pas
console.not_valid_why | not valid: {reason}          | zählt nicht: {reason}              | ne compte pas : {reason}
console.place       | trial {trial}                  | durchgang {trial}                  | essai {trial}
console.place_again | attempt {attempt}              | versuch {attempt}                  | tentative {attempt}
console.too_light   | too light                      | zu leicht                          | trop léger
console.too_heavy   | too heavy                      | zu stark                           | trop fort
console.stopped     | finger stopped                 | finger still                       | doigt arrêté
console.too_slow    | too slow                       | zu langsam                         | trop lent
console.too_fast    | too fast                       | zu schnell                         | trop rapide
console.lifted      | finger left                    | finger abgehoben                   | doigt levé
console.timeout     | touch not held time            | berührung nicht rechtzeitig        | toucher pas tenu temps
console.sensor_lost | sensor silent                  | sensor stumm                       | capteur muet
console.output_gap  | gap output                     | lücke ausgabe                      | coupure sortie
console.experimenter | invalidated experimenter           | wunsch versuchsleitung             | demande étude
console.force       | {force_n:.2f} n                | {force_n:.2f} n                    | {force_n:.2f} n
console.not_released | {force_n:.2f} not released    | {force_n:.2f} nicht losgelassen    | {force_n:.2f} non relevé
console.played      | played {force_n:.2f}           | ausgegeben {force_n:.2f}           | émis {force_n:.2f}
console.played_unmeasured | played no force          | ausgegeben keine kraft             | émis sans force
console.not_played  | not played                     | nicht ausgegeben                   | non émis
console.paused      | paused {by}                    | angehalten {by}                    | pause {by}
console.goes_on     | session continues              | geht weiter                        | reprend
"""
ROWS = [[cell.strip() for cell in line.split("|")] for line in TABLE.strip().splitlines()]
HELD = {language: {name: words[n].split() for name, *words in ROWS} for n, language in enumerate(COLUMNS)}
ALONE = ("no", "yes", "right", "wrong", "same", "different")
"""Texts that consist of exactly their word."""


def said_in(language):
    texts = texts_in(language, {})
    told = {f"console.{name}": text for name, text in phrases_in(language).items()}
    return {**texts.messages, **texts.labels, **told}


def lacks(language, name, text):
    """Return the required words that are missing from a text."""
    told = text.casefold()
    if name in ALONE:
        return [] if [told] == HELD[language][name] else HELD[language][name]
    return [word for word in HELD[language][name] if word not in told]


def test_word_table_covers_every_language_and_text():
    assert sorted(COLUMNS) == sorted(languages()), "add a column of words for each language"
    for language in COLUMNS:
        assert sorted(HELD[language].keys() ^ said_in(language).keys()) == [], "add a row of words for each text"


@pytest.mark.parametrize("language", COLUMNS)
def test_each_text_contains_its_words(language):
    missing = {name: lacks(language, name, text) for name, text in said_in(language).items()}
    assert {name: words for name, words in missing.items() if words} == {}


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
