"""Questionnaires: files, presentation of items, and scores."""

import csv
from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from places import SHARED

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.questionnaire import Item, load, parse, shipped_names

FULL = load("attrakdiff")
PUBLISHED = [
    *("PQ1", "HQI1", "ATT1", "HQS1", "PQ2", "HQI2", "ATT2", "PQ3", "ATT3", "PQ4", "HQI3", "PQ5", "HQI4", "HQI5"),
    *("HQI6", "HQI7", "ATT4", "HQS2", "ATT5", "PQ6", "ATT6", "HQS3", "HQS4", "HQS5", "HQS6", "ATT7", "HQS7", "PQ7"),
]
per_form = pytest.mark.parametrize("form", [load(name) for name in shipped_names()], ids=shipped_names())
raw_answers = st.fixed_dictionaries({name: st.integers(1, 7) for name in PUBLISHED})

SMALL = """
name = "small"
title = "Small"
reference = "none"
low = 1.0
high = 7.0
steps = 7
score_low = -3.0
score_high = 3.0
items = [
    { id = "A", dimension = "D", order = 2, poles = { en = ["Bad", "Good"] } },
    { id = "B", dimension = "D", order = 1, reversed = true, poles = { en = ["Ugly", "Fair"] } },
]
[dimensions.D]
min_answered = 1
"""


def scores(answers, form=FULL):
    return form.scores(answers)


def straight(raw, form=FULL):
    return {item.id: raw for item in form.items}


def test_attrakdiff_items_have_the_published_order():
    assert [item.id for item in FULL.items] == PUBLISHED


def test_fifteen_items_are_reversed():
    dimensions = [item.dimension for item in FULL.items if item.reversed]
    assert Counter(dimensions) == {"PQ": 4, "HQI": 3, "HQS": 4, "ATT": 4}


def test_poles_and_reversals_match_the_item_list():
    path = SHARED / "science" / "attrakdiff_items.csv"
    if not path.is_file():
        pytest.skip("the folder of shared data is not next to the checkout")
    rows = list(csv.DictReader(path.read_text("utf-8").splitlines()))
    listed = {row["item"]: (row["negative_pole_en"], row["positive_pole_en"], row["reversed"] == "yes") for row in rows}
    assert {item.id: (*item.poles["en"], item.reversed) for item in FULL.items} == listed


@pytest.mark.parametrize(("raw", "sevenths"), [(7, (-3, 3, -3, -3, 0)), (4, (0, 0, 0, 0, 0)), (1, (3, -3, 3, 3, 0))])
def test_straight_lines_give_the_published_values(raw, sevenths):
    assert scores(straight(raw)) == pytest.approx(
        dict(zip(("PQ", "HQI", "HQS", "ATT", "HQ"), [n / 7 for n in sevenths], strict=True)), abs=1e-15
    )


@given(answers=raw_answers, flipped=st.sets(st.sampled_from(PUBLISHED)), order=st.permutations(PUBLISHED))
def test_scores_are_independent_of_order_and_reversals(answers, flipped, order):
    items = tuple(
        replace(item, reversed=item.reversed != (item.id in flipped), order=order.index(item.id)) for item in FULL.items
    )
    presented = {name: 8 - raw if name in flipped else raw for name, raw in answers.items()}
    assert scores(presented, replace(FULL, items=items)) == pytest.approx(scores(answers), abs=1e-12)


@given(answers=raw_answers)
def test_hedonic_quality_is_the_mean_of_its_halves(answers):
    found = scores(answers)
    assert found["HQ"] == pytest.approx((found["HQI"] + found["HQS"]) / 2, abs=1e-12)


@given(answers=raw_answers, missing=st.sets(st.sampled_from(PUBLISHED)))
def test_dimension_score_needs_five_of_seven_answers(answers, missing):
    found = scores({name: None if name in missing else raw for name, raw in answers.items()})
    for name in ("PQ", "HQI", "HQS", "ATT"):
        assert (found[name] is None) == (len(missing & set(FULL.items_of(name))) > 2)


def test_reversed_item_has_positive_pole_on_left():
    assert FULL.words("PQ1", "en") == ("", "Human", "Technical")
    assert FULL.words("PQ4", "fr") == ("", "fastidieux", "efficace")


def test_sus_scores_match_brooke():
    odd_high = {item.id: 5.0 if item.order % 2 else 1.0 for item in load("sus").items}
    assert load("sus").scores(odd_high) == {"SUS": 100.0}
    assert load("sus").scores(straight(3, load("sus"))) == {"SUS": 50.0}


def test_reversed_statement_keeps_its_scale_ends():
    assert load("sus").words("SUS2", "en")[1:] == load("sus").words("SUS1", "en")[1:]


@per_form
def test_every_item_can_be_presented_in_each_language(form):
    assert set(form.languages) >= {"de", "en", "fr"}
    assert all(all(form.words(item.id, language)[1:]) for item in form.items for language in form.languages)


@per_form
def test_best_answers_give_the_highest_scores(form):
    best = {item.id: form.low if item.reversed else form.high for item in form.items}
    assert set(form.scores(best).values()) == {form.score_high}


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('["Bad", "Good"]', '["Bad"]', "small.toml, items[0].poles.en: found ['Bad'], expected two words"),
        ('["Bad", "Good"]', '["Bad", " "]', "items[0].poles.en: found ['Bad', ' '], expected two words, the negative"),
        ('poles = { en = ["Bad", "Good"] }', "poles = {}", "items[0].poles: found none for 'A', expected two poles"),
        ('{ en = ["Bad", "Good"] }', '{ fr = ["Mal", "Bien"] }', "items: found no language with texts for all"),
        ("score_low = -3.0", "score_low = nan", "score_low: found nan with score_high 3, expected two different"),
        ("score_high = 3.0", "score_high = -3.0", "score_low: found -3 with score_high -3, expected two different"),
        ('id = "B"', 'id = "A"', "items[1].id: found 'A' twice, expected each id once"),
        ("order = 1", "order = 2", "items[1].order: found 2 twice, expected each order once"),
        ('n = "D", order = 2', 'n = "E", order = 2', "items[0].dimension: found 'E', expected one of D"),
        ("reversed = true", 'reversed = "yes"', "items[1].reversed: found 'yes', expected true or false"),
        ("reversed", "reverse", "items[1].reverse: found an unknown key"),
        ("steps = 7", "steps = 1", "steps: found 1, expected at least 2"),
        ("low = 1.0", "low = 9.0", "low: found 9, expected a number below high (7)"),
        ("min_answered = 1", "min_answered = 3", "dimensions.D.min_answered: found 3, expected from 1 to the number"),
        ("title", "titel", "titel: found an unknown key"),
        ('name = "small"', "name = ", "found no valid TOML"),
    ],
)
def test_invalid_questionnaire_is_refused_in_one_sentence(old, new, sentence):
    with pytest.raises(InvalidFile) as refused:
        parse(SMALL.replace(old, new, 1).encode(), "small.toml")
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("raw", "words"), [(8, "1 to 7 in 7 steps"), (1.5, "in 7 steps"), (float("nan"), "1 to 7")])
def test_answers_off_the_scale_are_refused(raw, words):
    with pytest.raises(InvalidParameter, match=words):
        FULL.score("PQ1", raw)


def test_unknown_names_are_refused_with_a_suggestion():
    with pytest.raises(InvalidParameter, match="did you mean 'attrakdiff'"):
        load("atrakdiff")
    with pytest.raises(InvalidParameter, match="did you mean 'PQ1'"):
        FULL.score("PQ11", 4)
    with pytest.raises(InvalidParameter, match="expected one of de, en, fr"):
        FULL.words("PQ1", "it")


def test_items_are_sorted_by_order():
    form = parse(SMALL.encode(), "small.toml")
    assert [item.id for item in form.items] == ["B", "A"]
    assert form.item("A") == Item("A", "D", 2, poles={"en": ("Bad", "Good")})
