"""Hybrid scenes, cached results and films."""

from dataclasses import replace

import numpy as np
import pytest
from scene_cases import effect, panel, screen, small_screen

from tactometry.errors import InvalidParameter
from tactometry.stimuli.composition.effect import FingerContact
from tactometry.stimuli.scenes import cache
from tactometry.stimuli.scenes.cache import cached_result
from tactometry.stimuli.scenes.figures.courses import write_film
from tactometry.stimuli.scenes.plan import compute
from tactometry.stimuli.scenes.scene import Scene
from tactometry.stimuli.scenes.surfaces.electrovibration import Electrovibration
from tactometry.stimuli.scenes.surfaces.hybrid import HybridScreen

TONE = Electrovibration(60.0, duration_s=0.05, ramp_s=0.01)
REST, SLIDE = FingerContact(2.0), FingerContact(2.0, speed_m_per_s=0.05, x_m=0.09, y_m=0.06)
GIVEN = {"voltage_v": 30.0, "level_db_re_1v": 40.0}
FOCUS = (effect("attenuation", tau_s=2e-3), effect("one_bit"), effect("finger_load"))
FRICTION = (effect("force_law", law="sc_layer"), effect("skin_leakage"), effect("friction"))
HYBRID = Scene(
    HybridScreen(TONE, small_screen()), (*FOCUS, *FRICTION), ("peak_m", "friction_force_n"), 0.01, (SLIDE, REST)
)


def run(scene):
    plan = scene.resolve()
    return plan.run({name: GIVEN[name] for name in plan.given})


def test_sliding_finger_weakens_focus_under_resting_finger():
    both, one = run(HYBRID), run(screen(*FOCUS))
    assert both["peak_m"] < 0.995 * one["peak_m"]


def test_resting_fingers_come_first_and_feel_focus():
    felt = replace(
        HYBRID, effects=(*HYBRID.effects, effect("focus_detection")), outputs=("contact_force_n", "sensation_db")
    )
    got = run(felt)
    rest, slide = np.abs(got["contact_force_n"]).max(axis=1)
    assert rest > slide
    assert run(replace(felt, contacts=(REST, SLIDE)))["sensation_db"] == got["sensation_db"]


def test_unneeded_hybrid_side_has_no_stages():
    dragged = replace(HYBRID, outputs=("friction_force_n",)).resolve()
    assert not any("time_reversal" in stage.target or stage.gives == "motion" for stage in dragged.stages)
    assert dragged.given == ("level_db_re_1v",)
    focused = replace(HYBRID, outputs=("peak_m",)).resolve()
    assert not any("electrovibration" in stage.target for stage in focused.stages)


def test_hybrid_stages_have_distinct_names():
    plan = replace(HYBRID, outputs=("t_s", "focus_displacement_m", "sliding_t_s", "friction_force_n")).resolve()
    names = [stage.name for stage in plan.stages]
    assert len(set(names)) == len(names)
    assert {"sampling", "sliding_sampling"} <= set(names)


def test_sliding_finger_without_place_is_refused():
    with pytest.raises(InvalidParameter, match=r"contacts\[0\]: .* slides without a place, .*add x_m and y_m"):
        replace(HYBRID, contacts=(FingerContact(1.0, 0.05), REST)).resolve()


# --- kept results


def counting(monkeypatch):
    runs = []

    def counted(plan, given):
        runs.append(plan)
        return compute(plan, given)

    monkeypatch.setattr(cache, "compute", counted)
    return runs


def kept(scene, folder):
    plan = scene.resolve()
    return cached_result(plan, {name: GIVEN[name] for name in plan.given}, folder).values


def test_cached_result_is_identical_and_not_recomputed(tmp_path, monkeypatch):
    runs = counting(monkeypatch)
    first, second = kept(HYBRID, tmp_path), kept(HYBRID, tmp_path)
    assert len(runs) == 1
    assert first["peak_m"] == second["peak_m"]
    np.testing.assert_array_equal(first["friction_force_n"], second["friction_force_n"])
    kept(replace(HYBRID, accuracy=0.1), tmp_path)
    assert len(runs) == 2


@pytest.mark.parametrize("damage", ["torn", "altered", "empty", "one bit"])
def test_damaged_cache_file_is_recomputed(tmp_path, monkeypatch, damage):
    runs = counting(monkeypatch)
    first = kept(HYBRID, tmp_path)
    (file,) = tmp_path.glob("*.npz")
    if damage == "altered":
        with np.load(file) as held:
            arrays = {name: held[name] for name in held.files}
        np.savez(file, **(arrays | {"peak_m": 2 * arrays["peak_m"]}))
    else:
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 1
        torn = {"torn": content[: len(content) // 2], "empty": b"", "one bit": content}
        file.write_bytes(torn[damage])
    assert kept(HYBRID, tmp_path)["peak_m"] == first["peak_m"]
    assert kept(HYBRID, tmp_path)["peak_m"] == first["peak_m"]
    assert len(runs) == 2
    assert len(list(tmp_path.iterdir())) == 1


def test_cache_detects_any_flipped_bit(tmp_path):
    cache._write(tmp_path / "a.npz", {"peak_m": 1e-6})
    content = (tmp_path / "a.npz").read_bytes()
    for n in range(len(content)):
        turned = bytearray(content)
        turned[n] ^= 1 << n % 8
        (tmp_path / "b.npz").write_bytes(turned)
        assert cache._read(tmp_path / "b.npz") in (None, {"peak_m": 1e-6})


def test_cache_separates_outputs_of_equal_stages(tmp_path):
    alone, timed = (panel(outputs=("electrostatic_force_n", *more)) for more in ((), ("t_s",)))
    assert alone.resolve().stages == timed.resolve().stages
    assert set(kept(alone, tmp_path)) == {"electrostatic_force_n"}
    assert set(kept(timed, tmp_path)) == {"electrostatic_force_n", "t_s"}


def test_a_result_of_another_version_is_computed_again(tmp_path, monkeypatch):
    runs = counting(monkeypatch)
    kept(HYBRID, tmp_path)
    monkeypatch.setattr(cache, "versions", lambda: {"numpy": "0"})
    kept(HYBRID, tmp_path)
    assert len(runs) == 2


# --- films


def film():
    outputs = ("x_m", "y_m", "frames_s", "movie_m")
    shot = screen(*FOCUS, effect("movie", n_frames=3, span_s=1e-4), outputs=outputs, accuracy=0.1)
    plan = shot.resolve()
    return compute(plan, {"voltage_v": 30.0})


def test_a_film_has_a_picture_for_each_frame(tmp_path):
    from PIL import Image

    write_film(film(), "a focus", tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as picture:
        assert picture.n_frames == 3
    with pytest.raises(InvalidParameter, match=r"--movie: .*ends in \.gif or \.mp4"):
        write_film(film(), "a focus", tmp_path / "a.avi")


def test_a_film_has_the_colours_of_its_map(tmp_path):
    """A palette chosen per frame had only twenty colours."""
    from matplotlib import colormaps
    from PIL import Image

    write_film(film(), "a focus", tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as picture:
        picture.seek(1)
        shown = np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0).astype(float)
    for colour in 255 * colormaps["RdBu_r"](np.linspace(0, 1, 64))[:, :3]:  # its bar has all of them
        assert np.abs(shown - colour).max(axis=1).min() <= 3


def test_mp4_film_requires_ffmpeg(tmp_path, monkeypatch):
    pytest.importorskip("imageio_ffmpeg")
    write_film(film(), "a focus", tmp_path / "a.mp4")
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"
    monkeypatch.setattr("tactometry.stimuli.scenes.figures.courses._ffmpeg", lambda: "")
    with pytest.raises(InvalidParameter, match=r"--movie: found no ffmpeg, .*imageio-ffmpeg .*or write a \.gif"):
        write_film(film(), "a focus", tmp_path / "b.mp4")
    assert not (tmp_path / "b.mp4").exists()
