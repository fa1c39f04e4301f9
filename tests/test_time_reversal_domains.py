"""Outside of its domain each thing says so, in one clear sentence; within it nothing is NaN."""

import sys

import numpy as np
import pytest
from scipy.io import wavfile

from tactometry.errors import InvalidFile
from tactometry.stimuli.time_reversal.attenuation import Attenuation
from tactometry.stimuli.time_reversal.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.measured import read
from tactometry.stimuli.time_reversal.screen import Screen
from tactometry.stimuli.time_reversal.transducer import border

SAMPLES = np.random.default_rng(0).standard_normal((1, 2, 50))


def test_a_screen_takes_the_list_that_border_gives():
    from_list = Screen(A4_SCREEN, border(A4_SCREEN, 4), Attenuation(3e-3))
    assert from_list == Screen(A4_SCREEN, tuple(border(A4_SCREEN, 4)), Attenuation(3e-3))
    assert from_list.modal_forces(500.0).shape[1] == 4


def test_eight_bit_wav_is_unsigned_around_128(tmp_path):
    path = tmp_path / "a.wav"
    wavfile.write(path, 8000, np.array([[0, 64], [128, 192]], np.uint8))
    assert read([path], full_scale=2.0).samples.tolist() == [[[-2.0, 0.0], [-1.0, 1.0]]]


def npz(path, **arrays):
    np.savez(path, **{"samples": SAMPLES, "rate_hz": 1e5, **arrays})
    return path


def cut_npz(path):
    path.write_bytes(npz(path).read_bytes()[:400])


def corrupt_npz(path):
    whole = npz(path).read_bytes()
    path.write_bytes(whole[:500] + b"\xff" * 50 + whole[550:])


def npy_named_npz(path):
    with path.open("wb") as file:
        np.save(file, SAMPLES)


@pytest.mark.parametrize(
    "spoil",
    [cut_npz, corrupt_npz, npy_named_npz, lambda path: npz(path, rate_hz=[1e5, 2e5])],
    ids=["cut", "corrupt", "npy", "rates"],
)
def test_a_spoilt_npz_is_refused_with_its_name(tmp_path, spoil):
    path = tmp_path / "a.npz"
    spoil(path)
    with pytest.raises(InvalidFile, match=r"a\.npz: cannot be read as impulse responses: \S"):
        read([path])


def test_hdf5_with_a_number_for_a_quantity_is_refused(tmp_path):
    h5py = pytest.importorskip("h5py", reason="the extra hdf5 is not installed")
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file["samples"], file["rate_hz"], file["quantity"] = SAMPLES, 1e5, 3
    with pytest.raises(InvalidFile, match=r"a\.h5: cannot be read"):
        read([path])


def test_hdf5_without_its_extra_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InvalidFile, match=r"pip install tactometry\[hdf5\]"):
        read([tmp_path / "a.h5"])


@pytest.mark.parametrize(
    ("said", "factor"),
    [
        ("unit=m", 1.0),
        ("unit=mm", 1e-3),
        ("unit=um", 1e-6),
        ("unit=nm", 1e-9),
        ("unit=um scale=2", 2e-6),
        ("quantity=velocity unit=mm/s", 1e-3),
        ("quantity=acceleration unit=m/s2", 1.0),
    ],
)
def test_a_csv_file_says_its_unit(tmp_path, said, factor):
    path = tmp_path / "a.csv"
    path.write_text(f"# rate_hz=1000 {said}\na,b\n1,2\n3,4\n")
    np.testing.assert_allclose(read([path]).samples, factor * np.array([[[1, 3], [2, 4]]]), rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("# rate_hz=1000 unit=inch\na\n1\n2\n", "inch"),
        ("# rate_hz=1000 unit=um/s\na\n1\n2\n", "um/s"),
        ("# rate_hz=1000 units=um\na\n1\n2\n", "units"),
        ("# rate_hz=1000\n1,2\n3,4\n", "header"),
        ("# unit=um\na\n1\n", "rate_hz"),
    ],
)
def test_a_csv_file_that_would_be_misread_is_refused(tmp_path, text, found):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(InvalidFile, match=found):
        read([path])
