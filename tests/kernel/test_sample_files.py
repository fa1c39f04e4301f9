"""Sample files that are torn, damaged, or have wrong headers."""

import io
import json
import os
import struct
import zipfile
from functools import partial
from importlib.util import find_spec

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.io import wavfile

from tactometry.devices.outputs.file import read_signal
from tactometry.devices.sensors.recorded import RecordedSettings
from tactometry.errors import InvalidFile, InvalidParameter, TactometryError
from tactometry.files.durable import LARGEST_BYTES
from tactometry.provenance import sha256
from tactometry.stimuli.electrovibration.waveforms.wav_file import WavFile
from tactometry.stimuli.time_reversal.responses.learning import read_provenance
from tactometry.stimuli.time_reversal.responses.measured import read

SAMPLES = np.random.default_rng(0).normal(size=(1, 3, 50))


def npz(**arrays):
    file = io.BytesIO()
    np.savez(file, **{"samples": SAMPLES, "rate_hz": 1e5, "quantity": "velocity", **arrays})
    return file.getvalue()


def wav(frames):
    file = io.BytesIO()
    wavfile.write(file, 48_000, frames)
    return file.getvalue()


HEADER = "# rate_hz=100000 quantity=velocity unit=um/s\na,b,c\n"
ROWS = "\n".join(",".join(map(str, row)) for row in SAMPLES[0].T.tolist())
SOUND = {
    "x.npz": npz(provenance=json.dumps({"measured_by": "ZG"}), unit="V"),
    "x.wav": wav((3000 * SAMPLES[0].T).astype("<i2")),
    "y.wav": wav(SAMPLES[0].T),
    "x.csv": (HEADER + ROWS).encode(),
    "m.wav": wav(SAMPLES[0, 0] / 10),
    "r.csv": b"time_s,a\n0,1\n0.1,2\n",
}


def recording(path):
    RecordedSettings(str(path), 10.0).source().open()


def play(path):
    WavFile(str(path), 48_000.0, 50 / 48_000, sha256(path.read_bytes()))


READERS = {
    "x.npz": (lambda path: read([path]), read_provenance),
    "x.wav": (lambda path: read([path]), read_signal),
    "y.wav": (lambda path: read([path]), read_signal),
    "m.wav": (play,),
    "x.csv": (lambda path: read([path]),),
    "r.csv": (recording,),
}


def refusal(folder, name, content, reader=None):
    """Return the error message for a file, or None if it is read."""
    path = folder / name
    path.write_bytes(content)
    try:
        (reader or (lambda path: read([path])))(path)
    except TactometryError as error:
        said = str(error)
    else:
        return None
    assert f"{path}: " in said
    assert "\n" not in said
    return said.split(f"{path}: ", 1)[1]


@pytest.mark.parametrize("name", SOUND)
def test_valid_files_are_read(tmp_path, name):
    for reader in READERS[name]:
        assert refusal(tmp_path, name, SOUND[name], reader) is None


@pytest.mark.parametrize("name", SOUND)
@given(data=st.data())
def test_damaged_sample_files_are_read_or_refused_clearly(tmp_path_factory, name, data):
    folder, content = tmp_path_factory.getbasetemp(), bytearray(SOUND[name])
    begin, end = sorted(data.draw(st.tuples(*[st.integers(0, len(content))] * 2)))
    content[begin:end] = data.draw(st.binary(max_size=8) | st.just(b"") | st.just(content[begin:end] * 2))
    for _ in range(data.draw(st.integers(0, 4))):
        content[data.draw(st.integers(0, max(0, len(content) - 1))) : 1] = data.draw(st.binary(min_size=1, max_size=1))
    for reader in READERS[name]:
        refusal(folder, name, bytes(content), reader)


@pytest.mark.parametrize("name", ["x.wav", "y.wav"])
@pytest.mark.parametrize("part", [0.0, 0.2, 0.5, 0.99])
def test_torn_wav_file_is_refused(tmp_path, name, part):
    content = SOUND[name][: round(part * len(SOUND[name]))]
    for reader, error in zip(READERS[name], (InvalidFile, InvalidParameter), strict=True):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(
            error, match=r"found (no WAV file|\d+ of \d+ bytes of samples, expected all: the file is incomplete)"
        ):
            reader(tmp_path / name)


def changed(content, at, form, *values):
    packed = struct.pack(form, *values)
    return content[:at] + packed + content[at + len(packed) :]


WAV = SOUND["x.wav"]
DATA_AT = WAV.index(b"data") + 4


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"RIFF", "found no WAV file, expected a file that begins with RIFF and WAVE"),
        (wav(np.zeros((0, 2), "<i2")), "found no samples, expected"),
        (changed(WAV, DATA_AT, "<I", 0), "found no samples, expected at least one"),
        (changed(WAV, DATA_AT, "<I", 2**32 - 1), "found 300 of 4294967295 bytes of samples, expected all"),
        (changed(WAV, DATA_AT, "<I", 299), "found 299 bytes of samples, expected whole frames of 6 bytes"),
        (changed(WAV, 22, "<H", 0), "found 0 channels of 16 bits at 48000 Hz in frames of 6 bytes, expected consist"),
        (changed(WAV, 32, "<H", 7), "found 3 channels of 16 bits at 48000 Hz in frames of 7 bytes"),
        (changed(WAV, 24, "<I", 0), "found 3 channels of 16 bits at 0 Hz"),
        (changed(WAV, 34, "<H", 0), "found 3 channels of 0 bits"),
        (WAV[:12] + WAV[WAV.index(b"data") :], "found samples before their format, expected a chunk 'fmt ' first"),
        (WAV[: DATA_AT - 4], "found no samples, expected a chunk 'data': the file is incomplete"),
        (WAV[:30], "found no complete chunk 'fmt ', expected a complete one: the file is incomplete"),
    ],
)
def test_wav_file_with_wrong_header_is_refused(tmp_path, content, message):
    said = refusal(tmp_path, "x.wav", content)
    assert message in said, said


def test_wav_file_with_five_byte_floats_is_refused(tmp_path):
    content = changed(SOUND["m.wav"], 32, "<HH", 5, 40)
    for reader in (play, lambda path: read([path])):
        assert "found a damaged WAV file (" in refusal(tmp_path, "m.wav", content, reader)


def test_rf64_file_is_read_with_large_size(tmp_path):
    """RF64 files store 64-bit sizes in a separate chunk."""
    size = struct.unpack_from("<I", WAV, DATA_AT)[0]
    long = struct.pack("<4sIQQQI", b"ds64", 28, len(WAV), size, size // 6, 0)
    content = b"RF64" + struct.pack("<I", 2**32 - 1) + b"WAVE" + long + changed(WAV, DATA_AT, "<I", 2**32 - 1)[12:]
    assert refusal(tmp_path, "x.wav", content) is None
    torn = content[:-10]
    assert "found 290 of 300 bytes of samples, expected all" in refusal(tmp_path, "x.wav", torn)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            HEADER.replace("rate_hz=100000", "rate_hz=1 rate_hz=2") + ROWS,
            "rate_hz=1 rate_hz=2 quantity=velocity unit=um/s', expected each key once",
        ),
        (HEADER, "found no rows of numbers, expected at least one row"),
        ("# rate_hz=1000\n", "line 2: found '', expected a header row|found no rows of numbers"),
        ("", "'rate_hz' is not in the first line"),
        (HEADER + "1,2\n", "found 2 columns of numbers for 3 names, expected equal numbers"),
        (HEADER + "1,2,3\n1,2\n", "the number of columns changed from 3 to 2"),
        (HEADER + "1,nan,3\n", "samples[0, 1, 0]: found nan"),
        ("# rate_hz=1000\n1,2\n3,4\n", "header"),
        ("# unit=um\na\n1\n", "rate_hz"),
        ("# rate_hz=1000 unit=inch\na\n1\n2\n", "inch"),
        ("# rate_hz=1000 unit=um/s\na\n1\n2\n", "um/s"),
        ("# rate_hz=1000 units=um\na\n1\n2\n", "units"),
    ],
)
def test_csv_file_with_wrong_rows_is_refused(tmp_path, content, message):
    said = refusal(tmp_path, "x.csv", content.encode())
    assert any(part in said for part in message.split("|")), said


# --- NPZ


def npy(shape, descr="<f8"):
    """Return the bytes of an array of one number whose header states `shape`."""
    header = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + bytes(8)


def archive(samples):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in {"samples": samples, "rate_hz": npy("()")}.items():
            made.writestr(f"{name}.npy", content)
    return file.getvalue()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (archive(npy("(1, 32, 2**40)")), "samples: found a damaged array"),
        (archive(npy("(1, 1, 1)", "|O")), "samples: found a damaged array (Object arrays cannot be loaded"),
        (archive(npy("(1, 1, 2)")), "samples: found a damaged array"),
        (archive(b"nothing"), "samples: found a damaged array"),
        (npz(samples=np.zeros((1, 3, 0))), "as impulse responses: found no samples, expected at least one"),
        (npz(samples=np.array(["a"])), "samples: found an array of <U1, expected numbers"),
        (npz(rate_hz=[1.0, 2.0]), "rate_hz: found an array of shape (2,), expected a single number"),
        (npz(quantity=["velocity"]), "quantity: found an array of shape (1,), expected a single text"),
        (npz(quantity="x" * 2**19), "quantity: found 2097280 bytes, expected at most 1048576"),
        (npz()[:-30], "found no complete NPZ archive"),
    ],
    ids=lambda part: "archive" if isinstance(part, bytes) else part,  # its bytes hold the time of day
)
def test_npz_file_with_wrong_header_is_refused(tmp_path, content, message):
    said = refusal(tmp_path, "x.npz", content)
    assert message in said, said


def test_archive_bomb_is_refused_before_decompression(tmp_path, monkeypatch):
    monkeypatch.setattr("tactometry.files.samples.LARGEST_BYTES", 10**6)
    content = archive(bytes(10**8))
    assert len(content) < 10**6
    assert refusal(tmp_path, "x.npz", content) == (
        "cannot be read as impulse responses: samples: found 100000000 bytes, expected at most 1000000"
    )
    assert "found 100000000 bytes" in refusal(tmp_path, "x.npz", content, read_signal)


@pytest.mark.parametrize("name", READERS)
def test_oversized_sample_file_is_not_read(tmp_path, name):
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate(LARGEST_BYTES + 1)
    for reader in READERS[name]:
        with pytest.raises(TactometryError, match=rf"found {LARGEST_BYTES + 1} bytes, expected .* of at most"):
            reader(path)


def test_deeply_nested_provenance_is_refused(tmp_path):
    for words in ("[" * 100_000, '{"a":' * 100_000, "{", "3"):
        said = refusal(tmp_path, "x.npz", npz(provenance=words), read_provenance)
        assert said.startswith("cannot be read as learnt responses")


def test_pipes_and_folders_are_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / "x.wav")
    with pytest.raises(InvalidFile, match=r"x\.wav: found a pipe or a device, expected impulse responses"):
        read([tmp_path / "x.wav"])
    (tmp_path / "x.npz").mkdir()
    with pytest.raises(InvalidFile, match=r"x\.npz: found a folder, expected impulse responses"):
        read([tmp_path / "x.npz"])


# --- HDF5


@pytest.fixture
def hdf5(tmp_path):
    h5py = pytest.importorskip("h5py")

    def written(fill, quantity="velocity"):
        with h5py.File(tmp_path / "x.h5", "w") as file:
            file["rate_hz"], file["quantity"] = 1e5, quantity
            fill(h5py, file)
        return tmp_path / "x.h5"

    return written


def whole(h5py, file, samples=SAMPLES):
    file["samples"] = samples


def claiming_terabytes(h5py, file):
    file.create_dataset("samples", shape=(1, 32, 2**40), dtype="f8", chunks=(1, 1, 1024))


def linked_to_another_file(h5py, file):
    file["samples"] = h5py.ExternalLink("other.h5", "/samples")


def linked_through_a_group(h5py, file):
    file["other"] = h5py.ExternalLink("other.h5", "/")
    file["samples"] = h5py.SoftLink("/other/samples")


def quantity_as_a_number(h5py, file):
    whole(h5py, file)
    del file["quantity"]
    file["quantity"] = 3


def linked_to_itself(h5py, file):
    file["samples"] = h5py.SoftLink("/samples")


def a_group_in_itself(h5py, file):
    group = file.create_group("samples")
    group["samples"] = group


def virtual(h5py, file):
    layout = h5py.VirtualLayout(shape=(1, 3, 50), dtype="f8")
    layout[...] = h5py.VirtualSource("other.h5", "samples", shape=(1, 3, 50))
    file.create_virtual_dataset("samples", layout)


def stored_elsewhere(h5py, file):
    file.create_dataset("samples", shape=(1, 3, 50), dtype="f8", external=[("other.raw", 0, 1200)])


@pytest.mark.parametrize(
    ("fill", "message"),
    [
        (lambda h5py, file: None, "samples: found no dataset, or a link, expected a dataset of this file"),
        (claiming_terabytes, "samples: found 281474976710656 bytes, expected at most 1073741824"),
        (linked_to_another_file, "samples: found no dataset, or a link"),
        (linked_to_itself, "samples: found no dataset, or a link"),
        (linked_through_a_group, "samples: found no dataset, or a link"),
        (quantity_as_a_number, "dset.asstr() can only be used on datasets with an HDF5 string datatype"),
        (a_group_in_itself, "samples: found a group, expected a dataset of this file"),
        (virtual, "samples: found values of another file"),
        (stored_elsewhere, "samples: found values of another file"),
        (partial(whole, samples=[[["a"]]]), "samples: found "),
        (partial(whole, samples=np.zeros((1, 3, 0))), "found no samples, expected at least one"),
    ],
)
def test_hdf5_file_with_links_or_excess_is_refused(tmp_path, hdf5, fill, message):
    np.zeros(150).tofile(tmp_path / "other.raw")
    path = hdf5(fill)
    said = refusal(tmp_path, "x.h5", path.read_bytes())
    assert message in said, said


def test_hdf5_file_is_refused_when_its_library_hangs(tmp_path, hdf5, monkeypatch):
    """A wrong size in the heap makes the library loop forever."""
    content = hdf5(whole).read_bytes()
    assert refusal(tmp_path, "x.h5", content) is None
    monkeypatch.setattr("tactometry.files.hdf5.READ_WITHIN_S", 1.0)
    assert refusal(tmp_path, "x.h5", changed(content, content.index(b"GCOL") + 24, "<Q", 25)) is not None


@pytest.mark.skipif(find_spec("h5py") is None, reason="no h5py: extra hdf5")
def test_damaged_hdf5_files_are_read_or_refused_clearly(tmp_path, hdf5, monkeypatch):
    monkeypatch.setattr("tactometry.files.hdf5.READ_WITHIN_S", 3.0)
    content, rng = hdf5(whole).read_bytes(), np.random.default_rng()
    for _ in range(10):
        damaged = bytearray(content)
        for at in rng.integers(len(content), size=20):
            damaged[at] = rng.integers(256)
        refusal(tmp_path, "x.h5", bytes(damaged[: rng.integers(1, len(content))] if rng.random() < 0.3 else damaged))


def test_file_of_another_kind_is_refused(tmp_path):
    assert refusal(tmp_path, "x.txt", b"").startswith("found '.txt', expected one of .wav, .npz")
