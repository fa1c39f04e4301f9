"""Textures that follow a finger, and their study files."""

import hashlib
import struct
import zlib

import numpy as np
import pytest
from command_line import call
from felt_models import felt_by
from hypothesis import given, strategies as st
from study_texts import changed, wired
from tables import trial_rows

from tactometry.contact import Contact
from tactometry.errors import InvalidParameter
from tactometry.experiments.study.study_file import load
from tactometry.position_dependent import felt_under
from tactometry.stimuli.electrovibration import (
    AmplitudeModulated,
    Bump,
    ElectrovibrationSensation,
    Grating,
    GreyImage,
    HeightMap,
    Velvet,
)
from tactometry.stimuli.electrovibration.textures.followed_texture import FollowedTexture
from tactometry.stimuli.electrovibration.textures.texture import Region

SPEED_M_PER_S = 0.05
CONTACT = Contact(1.0, SPEED_M_PER_S)
TEXTURES = (
    Grating(1e-3),
    Region(0.01, 0.03),
    Bump(0.02, 5e-3),
    Velvet(),
    GreyImage(1e-3, (0.0, 1.0, 0.2)),
    HeightMap(5e-3, (0.0, 1.0, 0.0)),
)
TEXT = load("grating-roughness")[1].decode()
TABLE = 'texture = { kind = "grating", shape = "square" }'


def under(texture, times_s, path_m, level=30.0, **keys):
    stimulus = FollowedTexture(texture, **keys)
    return felt_under(stimulus, stimulus.at(level), np.asarray(times_s), np.asarray(path_m))


@pytest.mark.parametrize("frequency_hz", [25.0, 100.0, 240.0])
def test_sinusoidal_grating_feels_like_tone_at_constant_speed(frequency_hz):
    texture = Grating(SPEED_M_PER_S / frequency_hz, "sinusoidal")
    signal = under(texture, [0.0, 1.0], [0.0, SPEED_M_PER_S], rise_s=5e-5)
    tone = AmplitudeModulated(frequency_hz=frequency_hz, carrier_hz=2000.0).at(30.0)
    felt_db, tone_db = (felt_by(ElectrovibrationSensation()).sensation_db(each, CONTACT) for each in (signal, tone))
    assert felt_db == pytest.approx(tone_db, abs=0.05)


@pytest.mark.parametrize("texture", TEXTURES, ids=lambda texture: type(texture).__name__)
@given(seed=st.integers(0, 2**32 - 1), n_first=st.integers(1, 199))
def test_path_in_pieces_equals_whole_path(texture, seed, n_first):
    path_m = 0.02 + np.cumsum(np.random.default_rng(seed).normal(0.0, 2e-3, 200))
    stimulus = FollowedTexture(texture)
    first, before = stimulus.parts(path_m[:n_first])
    second, _ = stimulus.parts(path_m[n_first:], before)
    np.testing.assert_allclose(np.r_[first, second], stimulus.parts(path_m)[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("texture", TEXTURES, ids=lambda texture: type(texture).__name__)
@given(seed=st.integers(0, 2**32 - 1), rise_s=st.floats(1e-4, 5e-3))
def test_texture_parts_have_limited_rise(texture, seed, rise_s):
    path_m = np.random.default_rng(seed).uniform(-0.01, 0.05, 500)
    stimulus = FollowedTexture(texture, rise_s=rise_s)
    parts, _ = stimulus.parts(path_m)
    assert 0 <= parts.min() <= parts.max() <= 1
    assert np.abs(np.diff(parts)).max() <= (1 + 1e-9) / (rise_s * stimulus.rate_hz) + 1e-12


@pytest.mark.parametrize("texture", [Bump(0.02, 5e-3), HeightMap(0.01, (0.0, 1.0, 0.0))])
def test_returning_finger_meets_opposite_flank(texture):
    forth_m = np.linspace(0.0, 0.04, 4001)
    path_m = np.r_[forth_m, forth_m[::-1]]
    roots, _ = FollowedTexture(texture, rise_s=5e-5, turn_m=0.0).parts(path_m)
    share = roots**2
    assert share[800] > 0.6
    assert share[-801] == pytest.approx(1 - share[800], abs=1e-9)


def test_noise_of_the_position_turns_no_finger():
    path_m = np.linspace(0.0, 0.04, 4000) + np.random.default_rng(1).uniform(-9e-5, 9e-5, 4000)
    sure, _ = FollowedTexture(Velvet(tuft_depth=0.0)).parts(path_m)
    unsure, _ = FollowedTexture(Velvet(tuft_depth=0.0), turn_m=0.0).parts(path_m)
    assert np.ptp(sure) < 1e-12
    assert np.ptp(unsure) > 0.01


def test_study_texture_follows_path_of_each_finger(tmp_path, capsys):
    text = changed(TEXT, {"repeats = 4": "repeats = 1"})
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    words = ("simulate", tmp_path / "study.toml", "--participants", 1, "--seed", 3, "--out", tmp_path / "d")
    assert call(capsys, *words)[0] == 0
    rows = trial_rows(tmp_path / "d")
    assert {row["period_m"] for row in rows} == {"0.0005", "0.001", "0.002", "0.004"}
    assert call(capsys, "replay", tmp_path / "d")[0] == 0
    assert call(capsys, "validate", tmp_path / "d")[0] == 0
    journal = next((tmp_path / "d" / "journals").glob("*.jsonl")).read_text()
    digests = [line.split('"digest":"')[1][:16] for line in journal.splitlines() if '"digest":"' in line]
    assert len(set(digests)) == len(digests) > 15  # no two fingers go the same way


def study_of_map(kind, path, digest, more=""):
    """Return the study with the texture of a file instead of gratings of several periods."""
    texture = f'texture = {{ kind = "{kind}", pixel_m = "1 mm", path = "{path}", sha256 = "{digest}"{more} }}'
    varied = ("period_m = ", "counterbalance", "[variants", '"0.', "factor_sd_db")
    return "\n".join(line for line in changed(TEXT, {TABLE: texture}).splitlines() if not line.startswith(varied))


def test_maps_load_from_files_with_stated_digest(tmp_path):
    from PIL import Image as Picture

    Picture.fromarray(np.array([[0, 255, 51]] * 2, dtype=np.uint8)).save(tmp_path / "map.png")
    (tmp_path / "map.csv").write_text("0,1,0.2\n0,0,1\n")
    for name, row, at in (("map.png", 1, 0.2), ("map.csv", 0, 0.2), ("map.csv", 1, 1.0)):
        path = tmp_path / name
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        stimulus = next(iter(wired(study_of_map("image", path, digest, f", row = {row}")).bank.values()))
        assert float(stimulus.texture.force_share(2.5e-3)) == pytest.approx(at)
    with pytest.raises(InvalidParameter, match=f"GreyImage.sha256: found None, expected '{digest}', the digest of"):
        GreyImage(1e-3, path=str(path))


REFUSED = {
    "no texture": ({TABLE: ""}, "stimulus.texture.kind: found no such key, expected one of grating, edge, bump"),
    "another": ({TABLE: 'texture = { kind = "grate" }'}, "stimulus.texture.kind: found 'grate', .*grating"),
    "a key": ({TABLE: 'texture = { kind = "grating", phase = 1 }'}, "stimulus.texture.phase: found an unknown key"),
    "pressed": (
        {'kind = "slide"': 'kind = "press"', 'speed_m_per_s = "50 mm/s"': "", "speed_tolerance = 0.5": ""},
        "touch.kind: found 'press' with a texture, expected 'slide'",
    ),
    "too fast": ({'"50 mm/s"\nspeed': '"1 m/s"\nspeed'}, "stimulus.carrier_hz: found 2000 Hz, expected at least twice"),
}


@pytest.mark.parametrize(("changes", "words"), REFUSED.values(), ids=REFUSED)
def test_invalid_texture_is_refused_in_one_sentence(changes, words):
    with pytest.raises(InvalidParameter, match=words):
        wired(changed(TEXT, changes))


def png(width_px, height_px, *more):
    """Return a PNG with other chunks where rows are expected."""
    head = (b"IHDR", struct.pack(">IIBBBBB", width_px, height_px, 8, 0, 0, 0, 0))
    chunks = [head, (b"IDAT", zlib.compress(b"")), *more, (b"IEND", b"")]
    packed = (struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks)
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


NO_MAPS = {
    "no picture": ("map.png", b"words", "cannot be read (found no picture), expected CSV or PNG"),
    "a picture without pixels": ("map.png", png(0, 5), "map.png cannot be read ("),
    "a picture that fills the memory": ("map.png", png(60_000, 60_000), "(found more than 89478485 pixels)"),
    "a chunk of no standard": ("map.png", png(5, 5, (b"\x9aX\xe6`", b"")), "(broken PNG file (chunk b'"),
    "rows of two lengths": (
        "map.csv",
        b"0,1\n1\n",
        "(the number of columns changed from 2 to 1 at row 2), expected CSV",
    ),
    "no numbers": ("map.csv", b"", "(found no rows of numbers, expected at least one row), expected CSV"),
    "a number that is none": ("map.csv", b"0,nan\n", "stimulus.texture.values[1]: found nan, expected a finite number"),
}


@pytest.mark.parametrize("kind", ["image", "height_map"])
@pytest.mark.parametrize(("name", "content", "words"), NO_MAPS.values(), ids=NO_MAPS)
def test_file_without_map_is_refused_in_one_sentence(kind, name, content, words, tmp_path, capsys):
    path, digest = tmp_path / name, hashlib.sha256(content).hexdigest()
    path.write_bytes(content)
    (tmp_path / "study.toml").write_text(study_of_map(kind, path, digest), encoding="utf-8")
    status, said, _ = call(capsys, "run", tmp_path / "study.toml", "--participant", "P01", "--dry-run")
    assert (status, said.count("\n")) == (2, 0)
    assert words in said
