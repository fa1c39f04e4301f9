"""Outside of its domain each thing says so, in one clear sentence; within it nothing is NaN."""

import math
import sys

import numpy as np
import pytest
from scipy.io import wavfile

from tactometry.errors import InvalidFile, InvalidParameter
from tactometry.signal import Signal
from tactometry.stimuli.time_reversal.design.closed_forms import (
    Reverberation,
    focus_profile,
    half_wavelength_m,
    one_bit_amplitude_ratio,
    repetition_noise_ratio,
    resolution_m,
)
from tactometry.stimuli.time_reversal.filters import Band
from tactometry.stimuli.time_reversal.finger import Contactor
from tactometry.stimuli.time_reversal.focusing.focusing import Emission
from tactometry.stimuli.time_reversal.focusing.merit import area_m2, width_m
from tactometry.stimuli.time_reversal.focusing.pattern import Exponential, Pattern, burst_s, pattern_drive
from tactometry.stimuli.time_reversal.focusing.sound import noise
from tactometry.stimuli.time_reversal.plate.glass import A4_SCREEN
from tactometry.stimuli.time_reversal.plate.statics import bending_stress_pa, deflection_m
from tactometry.stimuli.time_reversal.responses.measured import read
from tactometry.stimuli.time_reversal.responses.responses import Responses, impulse_responses
from tactometry.stimuli.time_reversal.screen.attenuation import Attenuation
from tactometry.stimuli.time_reversal.screen.screen import Screen
from tactometry.stimuli.time_reversal.screen.transducer import border, capacitance_f
from tactometry.stimuli.time_reversal.stimulus.focus_train import TimeReversalStimulus

FOCUS = Responses(np.array([[[3.0, -2.0, 1.0]]]), 1e3)
LINE, BUMP = np.arange(5.0), np.array([0.0, 1.0, 4.0, 1.0, 0.0])
FIELD = np.outer(BUMP, BUMP)
NANS = np.array([1.0, math.nan, 1.0])
ROOM = Reverberation(32, 25e3, 3e-3, 6e-3, 18e-3)
TWO = Pattern(100.0, 20e-3, Exponential())
SMALL = Screen(A4_SCREEN, border(A4_SCREEN, 2), Attenuation(3e-3))
PULSE = Signal(np.array([[1.0, -1.0], [1.0, 1.0]]), 1e3, "V")
SAMPLING = {"rate_hz": 1e3, "duration_s": 5e-3, "f_max_hz": 500.0}
SAMPLES = np.random.default_rng(0).standard_normal((1, 2, 50))


def test_screen_accepts_list_from_border():
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


def linked(file, h5py, secret):
    file["samples"] = h5py.ExternalLink(str(secret), "samples")


def linked_through_a_group(file, h5py, secret):
    file["other"] = h5py.ExternalLink(str(secret), "/")
    file["samples"] = h5py.SoftLink("/other/samples")


def kept_elsewhere(file, h5py, secret):
    file.create_dataset("samples", shape=(8,), dtype="u1", external=[(str(secret), 0, 8)])


def virtual(file, h5py, secret):
    layout = h5py.VirtualLayout(SAMPLES.shape, SAMPLES.dtype)
    layout[...] = h5py.VirtualSource(str(secret), "samples", SAMPLES.shape, SAMPLES.dtype)
    file.create_virtual_dataset("samples", layout)


@pytest.mark.parametrize("point", [linked, linked_through_a_group, kept_elsewhere, virtual])
def test_hdf5_that_points_to_another_file_is_refused(tmp_path, point):
    h5py = pytest.importorskip("h5py", reason="the extra hdf5 is not installed")
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["samples"] = SAMPLES
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["rate_hz"] = 1e5
        point(file, h5py, tmp_path / "secret.h5")
    with pytest.raises(
        InvalidFile, match=r"a\.h5: cannot be read as impulse responses: samples: found (no dataset, or a link|values)"
    ):
        read([tmp_path / "a.h5"])


def test_hdf5_without_its_extra_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    (tmp_path / "a.h5").touch()
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
def test_csv_file_is_refused_when_header_is_wrong(tmp_path, text, found):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(InvalidFile, match=found):
        read([path])


OUTSIDE = {
    "width of zeros": (lambda: width_m(LINE, np.zeros(5)), "profile"),
    "width of unequal": (lambda: width_m(LINE, BUMP[:3]), "profile"),
    "width descending": (lambda: width_m(LINE[::-1], BUMP), "at_m"),
    "width level": (lambda: width_m(LINE, BUMP, 1.0), "level"),
    "area of zeros": (lambda: area_m2(np.zeros((5, 5)), (LINE, LINE)), "field_m"),
    "area of another grid": (lambda: area_m2(FIELD, (LINE[:3], LINE)), "field_m"),
    "capacitance of no thickness": (lambda: capacitance_f(1e-4, 0.0), "thickness_m"),
    "deflection off the plate": (lambda: deflection_m(A4_SCREEN, 1.0, (0.1, 0.1), 0.1, 9.0), "x_m, y_m"),
    "one bit tau": (lambda: one_bit_amplitude_ratio(1.0, -1.0), "tau_s"),
    "one bit T": (lambda: one_bit_amplitude_ratio([1.0, -1.0], 1.0), r"reversal_s\[1\]"),
    "repetition": (lambda: repetition_noise_ratio(0.0, 1.0), "repetition_s"),
    "resolution level 0": (lambda: resolution_m(A4_SCREEN, Band(0.0, 1e3), 0.0), "level"),
    "resolution level 1": (lambda: resolution_m(A4_SCREEN, Band(0.0, 1e3), 1.0), "level"),
    "half a wavelength": (lambda: half_wavelength_m(A4_SCREEN, -1.0), "f_mean_hz"),
    "burst weight": (lambda: burst_s(2.0, 7e-3, 3e-3), "weight"),
    "pattern tau": (lambda: pattern_drive(FOCUS, TWO, 1.0, modulation="burst", tau_s=-1.0), "tau_s"),
    "stimulus T": (lambda: TimeReversalStimulus(FOCUS, reversal_s=0.0), "reversal_s"),
    "emission T": (lambda: Emission(Band(0.0, 1e3), 0.0, 1e4), "reversal_s"),
    "noise of no time": (lambda: noise(SMALL, PULSE, 500.0, duration_s=0.0), "duration_s"),
    "quantity": (lambda: impulse_responses(SMALL, [(0.1, 0.1)], **SAMPLING, quantity="x"), "quantity"),
    "points of three": (lambda: impulse_responses(SMALL, [(0.1, 0.1, 0.1)] * 2, **SAMPLING), "points"),
    "one bare point": (lambda: impulse_responses(SMALL, (0.1, 0.1), **SAMPLING), "points"),
    "contactor off": (lambda: Contactor("soft").loads(A4_SCREEN, (9.0, 9.0), 1.0), "at_m"),
    "finger off": (lambda: Contactor("finger").loads(A4_SCREEN, (9.0, 9.0), 1.0), "at_m"),
    "stress of a large contact": (lambda: bending_stress_pa(A4_SCREEN, 1.0, 0.25), "contact_m"),
}


@pytest.mark.parametrize(("call", "names"), OUTSIDE.values(), ids=OUTSIDE)
def test_outside_of_the_domain_one_sentence(call, names):
    with pytest.raises(InvalidParameter, match=names) as caught:
        call()
    assert "found" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("level", [1e-3, 0.1, 0.5, 0.999])
@pytest.mark.parametrize("band", [Band(0.0, 25e3), Band(20e3, 20.1e3)], ids=["wide", "narrow"])
def test_every_level_below_the_peak_has_a_width(band, level):
    width = resolution_m(A4_SCREEN, band, level)
    assert focus_profile(A4_SCREEN, band, width / 2) == pytest.approx(level, abs=1e-9)


def test_the_whole_weight_takes_the_whole_reversal():
    assert burst_s(1.0, 7e-3, 1e-6) == 7e-3
    assert burst_s(0.0, 7e-3, 3e-3) == 0.0
