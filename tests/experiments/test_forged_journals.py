"""Errors for journals with valid checksums and wrong content, and for bytes after their end."""

import json
import shutil
import tracemalloc
import zlib
from pathlib import Path

import pytest
from command_line import call, output, refused, status
from hypothesis import given, settings, strategies as st
from places import RECORDED
from soak import SOAK

from tactometry.errors import InvalidFile, TactometryError
from tactometry.experiments.data_sets.replaying import rebuild_data_set, replay_data_set
from tactometry.experiments.data_sets.validation import validate
from tactometry.experiments.sessions.recording import Who, record, simulated
from tactometry.experiments.study.experiment import wire
from tactometry.experiments.study.study_file import parse
from tactometry.records.data_set import sessions
from tactometry.records.journal import checksum, encode, read
from tactometry.session.answer import Adjusted, Filled, Rated
from tactometry.session.request import Adjust, Enter, Fill, Question, flaw

SETS = ("console", "inquiries", "preference", "adjustment")
VALUES = [None, True, 0, -1, 2**62, 3.5, 1e308, -1e308, "", "x", "../../x", "=x", "a\nb", [], [1], {}, {"a": 1}]


def journal_of(root):
    return next(path for path in sorted((root / "journals").glob("*.jsonl")) if "interruptions" not in path.name)


def lines_of(path):
    tables = [json.loads(line) for line in path.read_bytes().split(b"\n")[:-1]]
    return [{key: value for key, value in table.items() if key != "crc32"} for table in tables]


def write(path, tables):
    content, before = b"", 0
    for table in tables:
        line = encode(table, before)
        content, before = content + line, checksum(line)
    path.write_bytes(content)


def leaves(value, place=()):
    """Yield the place of each value, also in inner tables and lists."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inner:
        yield (*place, key)
        yield from leaves(part, (*place, key))


def change(table, place, value):
    *way, last = place
    for key in way:
        table = table[key]
    table[last] = value


def forged(name, tmp_path, *changes):
    """Copy a data set and change journal values: (line from 0, place, value)."""
    root = Path(shutil.copytree(RECORDED / name, tmp_path / name))
    path = journal_of(root)
    tables = lines_of(path)
    for line, place, value in changes:
        change(tables[line], place, value)
    write(path, tables)
    return root


def resume(root):
    content = (root / "study.toml").read_bytes()
    experiment, who = wire(parse(content, "study.toml"), "study.toml"), Who("P01", seed=None)
    record(experiment, content, root, who, simulated(experiment, who), resume=True)


@given(
    name=st.sampled_from(SETS),
    line=st.integers(0, 10**6) | st.just(0),
    place=st.integers(0, 10**6),
    value=st.sampled_from(VALUES),
    n_left=st.integers(0, 10**6),
)
@settings(max_examples=1000 if SOAK else 25)
def test_forged_values_never_give_a_traceback(tmp_path_factory, name, line, place, value, n_left):
    root = Path(shutil.copytree(RECORDED / name, tmp_path_factory.mktemp("forged") / "d"))
    path = journal_of(root)
    tables = lines_of(path)
    n = line % len(tables)
    places = list(leaves(tables[n]))
    change(tables[n], places[place % len(places)], value)
    write(path, tables[: max(n + 1, n_left % (len(tables) + 1))])
    for use in (validate, replay_data_set, resume, rebuild_data_set, validate):
        try:
            use(root)
        except TactometryError:
            continue


HEADS = {
    "participant": "../../etc",
    "study": "Not A Name",
    "study_sha256": "abc",
    "session": -1,
    "number": 0,
    "seed": -1,
    "rig": "nobody",
    "format": 99,
    "started_utc": "yesterday",
}


@pytest.mark.parametrize("key", HEADS)
def test_forged_journal_heads_are_refused(tmp_path, key):
    root = forged("bench", tmp_path, (0, (key,), HEADS[key]))
    with pytest.raises(InvalidFile, match=rf"line 1: found the {key} .*, expected the head of a journal"):
        read(journal_of(root))


def n_of(root, request):
    """Return the index of the first line with such a request."""
    return next(n for n, table in enumerate(lines_of(journal_of(root))) if table.get("request") == request)


ANSWERS = {
    "option": ("console", "Choose", ("answer", "option"), 9, "the option 9, expected one of 0, 1"),
    "values": ("inquiries", "Fill", ("answer", "values"), [1.0], "1 values, expected one for each of"),
    "value": ("inquiries", "Fill", ("answer", "values", 0), 999.0, "the value 999, expected from"),
    "reading": ("force-loss", "Enter", ("answer", "value"), -1.0, "the value -1, expected from 0 to 1e+15"),
    "level": ("adjustment", "Adjust", ("answer", "level"), 1e9, "the value 1e+09, expected from 0 to 40"),
    "request": ("console", "Choose", ("request",), [1], r"the request \[1\]"),
    "unknown request": ("console", "Choose", ("request",), "Chose", "the request 'Chose'"),
    "key of an answer": ("console", "Choose", ("answer", "more"), 1, "the key 'more'"),
    "key of a trial": ("console", "Record", ("asked", "trial", "levl"), 1, "the key 'levl'"),
    "key of a line": ("console", "Choose", ("more",), 1, "a line of 'request', 'asked', 'answer', 'more'"),
    "type": ("console", "Choose", ("answer", "latency_s"), "soon", "Expected `float`, got `str`"),
}


@pytest.mark.parametrize("wrong", ANSWERS)
def test_forged_answer_of_another_kind_is_refused(tmp_path, capsys, wrong):
    name, request, place, value, message = ANSWERS[wrong]
    line = n_of(RECORDED / name, request)
    root = forged(name, tmp_path, (line, place, value))
    with pytest.raises(InvalidFile, match=rf"line {line + 1}: found {message}".replace("+", r"\+")):
        read(journal_of(root))
    assert f"line {line + 1}: found" in refused(capsys, "replay", root)


@pytest.mark.parametrize(
    "body", [b'{"end":"complet"', b'{"end":"complete","x":1', b"{", b"[1", b'{"a":' + b"[" * 5000, b'{"a\xff":1']
)
def test_invalid_line_is_reported_with_its_number(tmp_path, body):
    path = tmp_path / "j.jsonl"
    first = (journal_of(RECORDED / "bench")).read_bytes().split(b"\n")[0] + b"\n"
    path.write_bytes(first + b'%s,"crc32":"%08x"}\n' % (body, zlib.crc32(body, checksum(first))))
    with pytest.raises(InvalidFile, match="line 2: found .*, expected a"):
        read(path)


@pytest.mark.parametrize("key", ["participant", "seed", "number", "study_sha256"])
def test_sittings_of_one_session_must_agree(tmp_path, key):
    name = "bench-repeated"
    tables = lines_of(journal_of(RECORDED / name))
    other = {"participant": "P02", "seed": 1, "number": 7, "study_sha256": "0" * 64}
    path = tmp_path / "j.jsonl"
    write(path, [tables[0], {"sitting": {**tables[0], "started_utc": None}}, *tables[1:]])
    assert len(read(path).sittings) == 2
    write(path, [tables[0], {"sitting": {**tables[0], key: other[key]}}, *tables[1:]])
    with pytest.raises(InvalidFile, match="line 2: found a sitting of a different session than the first line"):
        read(path)


def test_trial_without_a_key_has_the_default(tmp_path, capsys):
    line = n_of(RECORDED / "bench", "Record")
    root = Path(shutil.copytree(RECORDED / "bench", tmp_path / "d"))
    tables = lines_of(journal_of(root))
    del tables[line]["asked"]["trial"]["onset_s"]
    write(journal_of(root), tables)
    code, _, out = call(capsys, "validate", root)
    assert code == 1
    assert "found a row that differs from the journal" in out


def test_adjusted_levels_may_exceed_bounds_by_rounding():
    adjust = Adjust("tone", 0.1, 0.1, 0.0, 0.3)
    assert flaw(adjust, Adjusted(adjust.level(2), 0.0, 1.0)) is None
    assert flaw(adjust, Adjusted(0.31, 0.0, 1.0)) == "the value 0.31, expected from 0 to 0.3"
    assert flaw(Enter("x", 0.0), Rated(None, 0.0, 1.0)) is None
    assert flaw(Enter("x", 0.0), Rated(1e16, 0.0, 1.0)) == "the value 1e+16, expected from 0 to 1e+15"
    assert flaw(Fill("f", (Question("a", {}),), 1.0, 7.0, 7), Filled((None,), 0.0, 1.0)) is None


# --- bytes after the end of a complete journal

RUBBISH = {
    "one byte": b"x",
    "no newline": b"rubbish without newline",
    "spaces": b"   ",
    "zeros": bytes(4096),
    "invalid text": b"\xff\xfe",
    "torn line": b'{"event":"note","at',
}
LINES = {"newline": b"\n", "lines": b"a\nb\n", "line and rest": b"\r\n\0", "empty line and rest": b"\n\r"}
WORDS = ("run", "tutorial", "--participant", "P01", "--rig", "simulated", "--seed", "1", "--out")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    root = tmp_path_factory.mktemp("recorded") / "d"
    assert status(*WORDS, root) == 0
    return root


@pytest.fixture
def journal(recorded, tmp_path):
    (path,) = sessions(shutil.copytree(recorded, tmp_path / "d"))
    return path


@pytest.mark.parametrize("rubbish", RUBBISH | LINES)
def test_validate_reports_bytes_after_end(journal, rubbish):
    n_lines = journal.read_bytes().count(b"\n")
    journal.write_bytes(journal.read_bytes() + (RUBBISH | LINES)[rubbish])
    [defect] = validate(journal.parent.parent).defects
    assert (defect.file, defect.row) == (f"journals/{journal.name}", n_lines + 1)
    n_bytes = len(RUBBISH.get(rubbish, b""))
    expected = f"found {n_bytes} byte{'s' * (n_bytes != 1)} after the" if n_bytes else "found a line after the"
    assert f"{expected} end of the session, expected none" in defect.text


@pytest.mark.parametrize("rubbish", RUBBISH)
def test_rebuild_moves_bytes_after_end(capsys, journal, rubbish):
    before = journal.read_bytes()
    journal.write_bytes(before + RUBBISH[rubbish])
    output(capsys, "rebuild", journal.parent.parent)
    assert journal.read_bytes() == before
    assert journal.with_name(f"{journal.stem}_interruptions.jsonl").stat().st_size > 0
    assert validate(journal.parent.parent).defects == ()


def test_resume_names_bytes_after_end(capsys, journal):
    journal.write_bytes(journal.read_bytes() + b"rubbish")
    code, said, _ = call(capsys, *WORDS, journal.parent.parent, "--resume")
    assert code == 0
    assert f"7 bytes after the end of the session are kept in {journal.stem}_interruptions.jsonl" in said


def test_many_lines_after_end_need_little_memory(journal):
    journal.write_bytes(journal.read_bytes() + b"\n" * 10_000_000)
    tracemalloc.start()
    try:
        with pytest.raises(InvalidFile, match="found a line after the end"):
            read(journal)
        assert tracemalloc.get_traced_memory()[1] < 30e6
    finally:
        tracemalloc.stop()
