"""Following a journal that is written, cut, damaged or repaired."""

import pytest
from hypothesis import given, strategies as st
from tutorial_session import journal_of, live

from tactometry.errors import InvalidFile
from tactometry.experiments.sessions.recording import Who
from tactometry.records.following import Follower
from tactometry.records.journal import decode_journal, read
from tactometry.records.open_journal import Journal
from tactometry.session.event import Event


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    root = tmp_path_factory.mktemp("followed")
    live(root)
    return journal_of(root).read_bytes()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "journal.jsonl"


def lines_of(content, path):
    return decode_journal(content, path).lines


def whole(content, n_lines):
    return b"".join(content.splitlines(keepends=True)[:n_lines])


@given(data=st.data())
def test_follower_reads_each_line_once(content, tmp_path_factory, data):
    path = tmp_path_factory.mktemp("grows") / "journal.jsonl"
    follower, seen, complete = Follower(path), [], False
    ends = sorted(data.draw(st.lists(st.integers(0, len(content)), max_size=8)))
    for end in [*ends, len(content)]:
        path.write_bytes(content[:end])
        news = follower.news()
        if news is not None:
            assert not (news.anew and seen)
            seen += news.lines
            complete = news.complete
    assert tuple(seen) == lines_of(content, path)
    assert complete


def followed(path, content):
    """Return a follower that has read `content` at `path`."""
    path.write_bytes(content)
    follower = Follower(path)
    assert follower.news() is not None
    return follower


def test_unchanged_journal_has_no_news(content, path):
    assert followed(path, content).news() is None


@pytest.mark.parametrize("n_lines", [9, 0], ids=["cut", "emptied"])
def test_journal_that_is_cut_begins_anew(content, path, n_lines):
    follower = followed(path, content)
    path.write_bytes(whole(content, n_lines))
    news = follower.news()
    assert news.anew
    assert not news.complete
    assert news.lines == (lines_of(whole(content, n_lines), path) if n_lines else ())


def test_follower_begins_anew_with_another_longer_journal(content, path, tmp_path):
    live(tmp_path / "other", Who("P02", seed=9))
    longer = journal_of(tmp_path / "other").read_bytes()
    follower = followed(path, whole(content, 5))
    path.write_bytes(longer)
    news = follower.news()
    assert news.anew
    assert news.lines == lines_of(longer, path)


def test_file_that_replaces_a_journal_continues_it(content, path, tmp_path):
    follower = followed(path, whole(content, 5))
    (tmp_path / "draft").write_bytes(whole(content, 7))
    (tmp_path / "draft").replace(path)
    news = follower.news()
    assert not news.anew
    assert news.lines == lines_of(content, path)[5:7]


def test_follower_continues_when_session_is_resumed(content, tmp_path):
    root = tmp_path / "resumed"
    live(root)
    path = journal_of(root)
    # killed within a trial: the touch of trial 3 was answered, its row is missing
    follower = followed(path, whole(content, 13) + b'{"request":"Ch')
    live(root, resume=True)
    news = follower.news()
    assert news.complete
    seen = news.lines if news.anew else (*lines_of(whole(content, 13), path), *news.lines)
    assert seen == read(path).lines


def test_follower_names_damage_and_rereads_repaired_journal(content, path):
    follower = followed(path, whole(content, 5))
    spoiled = bytearray(whole(content, 8))
    spoiled[len(whole(content, 6)) + 12] ^= 1
    path.write_bytes(spoiled)
    with pytest.raises(InvalidFile, match="line 7: the line is damaged"):
        follower.news()
    path.write_bytes(content)
    news = follower.news()
    assert news.anew
    assert news.lines == lines_of(content, path)


def test_follower_reports_and_finds_a_missing_journal(content, path):
    follower = followed(path, content)
    path.unlink()
    with pytest.raises(InvalidFile, match="cannot be read"):
        follower.news()
    path.write_bytes(content)
    assert follower.news().anew


def test_follower_reads_a_locked_journal(content, path):
    path.write_bytes(whole(content, 5))
    writer = Journal(path, resume=True)
    try:
        follower = Follower(path)
        n_lines = len(follower.news().lines)
        writer.note(Event("remark", 1.0, facts={"text": "coughed"}))
        assert [line.kind for line in follower.news().lines] == ["remark"]
    finally:
        writer.close()
    assert len(read(path).lines) == n_lines + 1
