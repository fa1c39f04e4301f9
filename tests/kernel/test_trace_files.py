"""Trace files: complete members after kills and full disks."""

import gzip
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from full_disk import files_of_at_most
from hypothesis import given, settings, strategies as st

from tactometry.errors import DeviceFailed, InvalidFile
from tactometry.files.durable import make_folder
from tactometry.records.data_set import Session
from tactometry.records.traces import TraceFiles, decode_rows, encode_rows, packed, read_part, trace_file, whole_length

SESSION = Session("P01", 1, "tutorial")


@pytest.fixture
def files(tmp_path):
    made = TraceFiles(tmp_path, SESSION)
    yield made
    made.close()


def touch(seed, n=200, rng_of=np.random.default_rng):
    """Return samples of a touch that compress poorly."""
    return np.column_stack([np.arange(n) / 1000, rng_of(seed).uniform(0.0, 2.0, n)])


finite = st.floats(-1e6, 1e6) | st.just(float("nan"))


@given(st.lists(st.tuples(st.floats(0.0, 1e5), finite), min_size=1, max_size=30))
def test_trace_rows_survive_encoding(rows):
    table = np.array(rows)
    force, position = (decode_rows(encode_rows(kind, table)) for kind in ("force", "position"))
    np.testing.assert_allclose(force[:, 0], table[:, 0], atol=5.1e-7)
    np.testing.assert_allclose(force[:, 1], table[:, 1], rtol=5.1e-6)
    np.testing.assert_allclose(position[:, 1], table[:, 1], rtol=1e-15, atol=5.1e-10)


def test_trace_parts_are_read_from_their_offsets(tmp_path, files):
    tables = [touch(seed) for seed in range(3)]
    parts = [files.keep("force", table, 1000.0) for table in tables]
    for part, table in zip(parts, tables, strict=True):
        np.testing.assert_allclose(read_part(tmp_path, part), table, atol=5.1e-6)
    text = gzip.decompress(trace_file(tmp_path, SESSION, "force").read_bytes())
    assert text.count(b"\n") == 600


@settings(deadline=None)
@given(st.floats(0.0, 1.0, exclude_max=True))
def test_only_the_torn_member_is_cut_off(part_written):
    with TemporaryDirectory() as folder:
        root = Path(folder)
        before = TraceFiles(root, SESSION)
        kept = before.keep("force", touch(1), 1000.0)
        before.close()
        path, member = trace_file(root, SESSION, "force"), packed(encode_rows("force", touch(2)))
        with path.open("ab") as file:
            file.write(member[: int(part_written * len(member))])
        after = TraceFiles(root, SESSION)
        added = after.keep("force", touch(3), 1000.0)
        after.close()
        assert added.first_byte == kept.n_bytes
        assert path.stat().st_size == kept.n_bytes + added.n_bytes
        np.testing.assert_allclose(read_part(root, kept), touch(1), atol=5.1e-6)


def test_whole_member_is_kept_when_journal_lacks_it(tmp_path, files):
    """Traces that an older journal does not name are kept."""
    first, second = (files.keep("force", touch(seed), 1000.0) for seed in (1, 2))
    files.close()
    again = TraceFiles(tmp_path, SESSION)
    third = again.keep("force", touch(3), 1000.0)
    again.close()
    assert third.first_byte == first.n_bytes + second.n_bytes


def test_whole_length_separates_members_of_any_size():
    members = [packed(encode_rows("force", touch(seed, n))) for seed, n in enumerate((30_000, 1, 40_000, 3))]
    ends = np.cumsum([len(member) for member in members]).tolist()
    content = b"".join(members)
    assert len(members[0]) > 2**16
    for end, next_end in zip([0, *ends], ends, strict=False):
        assert whole_length(content[:next_end]) == next_end
        assert whole_length(content[: next_end - 1]) == end


def test_damage_within_a_file_is_not_cut_off():
    members = [bytearray(packed(encode_rows("force", touch(seed)))) for seed in range(3)]
    members[1][40] ^= 1
    content = b"".join(members)
    assert whole_length(content) == len(content)


def test_damaged_trace_part_is_refused(tmp_path, files):
    part = files.keep("force", touch(1), 1000.0)
    path = trace_file(tmp_path, SESSION, "force")
    path.write_bytes(bytes(part.n_bytes))
    with pytest.raises(
        InvalidFile, match="found other samples than were stored from byte 0 on, expected complete samples"
    ):
        read_part(tmp_path, part)
    path.unlink()
    with pytest.raises(InvalidFile, match=r"cannot be read \(No such file or directory\), expected traces"):
        read_part(tmp_path, part)


def test_full_disk_leaves_kept_traces_intact(tmp_path, files):
    first = files.keep("force", touch(1), 1000.0)
    refused = pytest.raises(DeviceFailed, match="expected free disk space; all earlier trials are safe; free")
    with files_of_at_most(first.n_bytes + 100), refused:
        files.keep("force", touch(2), 1000.0)
    assert trace_file(tmp_path, SESSION, "force").stat().st_size == first.n_bytes
    second = files.keep("force", touch(2), 1000.0)
    assert second.first_byte == first.n_bytes


def test_equal_samples_give_equal_bytes_in_private_files(tmp_path):
    made = []
    for name in ("a", "b"):
        make_folder(tmp_path / name)
        files = TraceFiles(tmp_path / name, SESSION)
        files.keep("position", np.column_stack([touch(1), touch(2)[:, 1]]), 250.0)
        files.close()
        path = trace_file(tmp_path / name, SESSION, "position")
        made.append(path.read_bytes())
        assert path.stat().st_mode & 0o777 == 0o600
    assert made[0] == made[1]
