"""JSON files: size limits and refusals in one sentence."""

import json

import pytest
from hypothesis import given, strategies as st

from tactometry.errors import InvalidFile
from tactometry.files.json_file import DEEPEST, LARGEST_OBJECT, json_items, json_object, json_value

TEXT = st.text(max_size=3)
VALUES = st.recursive(
    st.none() | st.booleans() | TEXT,
    lambda part: st.lists(part, max_size=3) | st.dictionaries(TEXT, part, max_size=3),
    max_leaves=5,
)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "found no JSON \\(Expecting value"),
        (b"\xff", "found no JSON \\('utf-8' codec"),
        (b"[" * 10**5, "found no JSON \\(nested deeper than 100 levels\\)"),
        (b"[" * 101 + b"]" * 101, "found no JSON \\(nested deeper than 100 levels\\)"),
        (b'{"\\ud800": 1}', "found no JSON \\('utf-8' codec can't encode"),
        (b'{"a": ["\\udfff"]}', "found no JSON \\('utf-8' codec can't encode"),
        (b"1" * 5000, "found no JSON \\(Exceeds the limit"),
        (b"[]", "found no JSON object"),
        (b" " * (LARGEST_OBJECT + 1), f"found {LARGEST_OBJECT + 1} bytes"),
    ],
    ids=["empty", "bytes", "open lists", "deep lists", "half a key", "half a text", "long number", "list", "large"],
)
def test_json_object_refuses_other_content(tmp_path, content, message):
    (tmp_path / "x.json").write_bytes(content)
    with pytest.raises(InvalidFile, match=f"x.json: {message}.*expected a description"):
        json_object(tmp_path / "x.json", "a description")


def test_json_value_accepts_the_deepest_nesting():
    text = "[" * DEEPEST + "]" * DEEPEST
    assert json.dumps(json_value(text)) == text


@given(
    st.lists(st.lists(VALUES, max_size=3), max_size=3), st.sampled_from([None, 2]), st.sampled_from(["", "\n", " \n\t"])
)
def test_json_items_yields_the_items_of_all_lists(lists, indent, between):
    text = between.join(json.dumps(each, indent=indent) for each in lists)
    assert list(json_items(between + text + between)) == [item for each in lists for item in each]


@pytest.mark.parametrize("text", ["{}", "[1", "[1,", "[1,]", "[,1]", "[1 2]", "[1]]", "[1] 2", "[" * 10**5])
def test_json_items_refuses_text_that_is_no_list(text):
    with pytest.raises(ValueError, match=r"Expecting|nested deeper"):
        list(json_items(text))
