"""Textures over position, the pile of a velvet, contact areas."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactometry.errors import InvalidParameter
from tactometry.stimuli.electrovibration.attraction.contact_area import (
    UNVERIFIED_PRINTS,
    PowerLawArea,
    Print,
    TableArea,
    area_of_prints,
    power_law_of_prints,
)
from tactometry.stimuli.electrovibration.textures.followed_texture import FollowedTexture
from tactometry.stimuli.electrovibration.textures.maps import GreyImage
from tactometry.stimuli.electrovibration.textures.texture import Bump, Grating, Noise, Region, Texture, Velvet

NOISE = Noise.drawn(100.0, 1000.0, 0.1, rng=np.random.default_rng(3))
TEXTURES = [
    *(Grating(2e-3, shape) for shape in ("square", "sinusoidal", "sawtooth")),
    Region(0.01, 0.03, 1e-3),
    Bump(0.02, 3e-3),
    Bump(0.02, 3e-3, height_sign=-1),
    NOISE,
    GreyImage(1e-3, tuple(np.linspace(0, 1, 50).tolist())),
]


@pytest.mark.parametrize("texture", TEXTURES)
@given(x_m=st.floats(-1, 1))
def test_every_texture_is_a_share(texture: Texture, x_m: float) -> None:
    assert 0 <= float(texture.force_share(x_m)) <= 1


@given(shape=st.sampled_from(["square", "sinusoidal", "sawtooth"]), n=st.integers(-5, 5), phase=st.floats(0.01, 0.49))
def test_a_grating_repeats(shape: str, n: int, phase: float) -> None:
    grating = Grating(2e-3, shape)
    assert float(grating.force_share((n + phase) * 2e-3)) == pytest.approx(float(grating.force_share(phase * 2e-3)))


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("square", [0.5, 2 / np.pi, 0.0, 2 / (3 * np.pi)]),
        ("sinusoidal", [0.5, 0.5, 0.0, 0.0]),
        ("sawtooth", [0.5, 1 / np.pi, 1 / (2 * np.pi), 1 / (3 * np.pi)]),
    ],
)
def test_spectrum_of_a_grating_under_a_finger(shape: str, expected: list[float]) -> None:
    grating, speed = Grating(1e-3, shape), 0.1
    share = grating.force_share(0.25e-6 + speed * np.arange(200_000) / 200_000)
    spectrum = np.abs(np.fft.rfft(share)) / share.size * np.r_[1, np.full(100_000, 2)]
    n = 100  # the speed over the period
    np.testing.assert_allclose(spectrum[[0, n, 2 * n, 3 * n]], expected, atol=1e-3)


@pytest.mark.parametrize("exponent", [0.0, -2.0])
def test_noise_texture_has_requested_spectrum(exponent: float) -> None:
    noise = Noise.drawn(100.0, 1000.0, 0.1, rng=np.random.default_rng(5), exponent=exponent)
    x_m = np.arange(1000) * 1e-4
    power = np.abs(np.fft.rfft(noise.height(x_m)) / 1000) ** 2 * 2
    lines = np.fft.rfftfreq(1000, 1e-4)
    inside = (lines > 95) & (lines < 1005)
    assert power[~inside].max() < 1e-25
    slope = np.polyfit(np.log(lines[inside]), np.log(power[inside]), 1)[0]
    assert slope == pytest.approx(exponent, abs=1e-9)
    assert noise.height(x_m).std() == pytest.approx(1.0, rel=1e-12)


def test_reversed_bump_is_a_hole() -> None:
    x_m = np.linspace(0, 0.04, 101)
    bump, hole = Bump(0.02, 3e-3, direction=-1), Bump(0.02, 3e-3, height_sign=-1)
    np.testing.assert_array_equal(bump.force_share(x_m), hole.force_share(x_m))


def test_bump_slope_integrates_to_its_height() -> None:
    x_m = np.linspace(-0.02, 0.06, 8001)
    height = np.cumsum(Bump(0.02, 3e-3).force_share(x_m) - 0.5) * 1e-5
    expected = np.exp(-(((x_m - 0.02) / 3e-3) ** 2) / 2) * 3e-3 * np.exp(0.5) / 2
    np.testing.assert_allclose(height, expected, atol=1e-5)


def test_velvet_tufts_beat_at_speed_over_their_distance() -> None:
    share = Velvet(tuft_period_m=1e-3).force_share_along(np.arange(10_000) * 0.1 / 10_000)
    spectrum = np.abs(np.fft.rfft(share - share.mean()))
    assert np.argmax(spectrum) == 100


@pytest.mark.parametrize(
    ("texture", "period_m"),
    [
        (Grating(1e-3), 1e-3),
        (Velvet(tuft_period_m=2e-3), 2e-3),
        (NOISE, 1e-3),
        (GreyImage(1e-3, tuple(np.linspace(0, 1, 50).tolist())), 2e-3),
        (Grating(1e-3, duty=0.9), 0.2e-3),
        (Bump(0.02, 3e-3), 6e-3),
        (Region(0.01, 0.03), 0.04),
        (Grating(1e-3, duty=1.0), None),
        (Velvet(tuft_depth=0.0), None),
    ],
)
def test_finest_period_sets_required_report_rate(texture: Texture, period_m: float) -> None:
    followed, needed_hz = FollowedTexture(texture, carrier_hz=5e3), 0.0 if period_m is None else 0.2 / period_m
    followed.check_motion(0.1, needed_hz * 1.001 + 1e-3)
    if period_m is not None:
        with pytest.raises(InvalidParameter, match="else the texture aliases"):
            followed.check_motion(0.1, needed_hz)


def test_prints_give_a_table_and_a_power_law() -> None:
    table, law = area_of_prints(UNVERIFIED_PRINTS[::-1]), power_law_of_prints(UNVERIFIED_PRINTS)
    for one in UNVERIFIED_PRINTS:
        assert float(table.area_m2(one.force_n)) == pytest.approx(np.pi * one.length_m * one.width_m / 4)
    assert 0.2 < law.exponent < 0.5
    exact = [Print(f, 0.01 * f**0.2, 0.01 * f**0.1) for f in (0.5, 1.0, 4.0)]
    assert power_law_of_prints(exact).exponent == pytest.approx(0.3)


@given(force_n=st.floats(0, 100), factor=st.floats(1, 10))
def test_a_power_law_scales(force_n: float, factor: float) -> None:
    law = PowerLawArea()
    ratio = float(law.area_m2(force_n * factor)) - factor ** (1 / 3) * float(law.area_m2(force_n))
    assert abs(ratio) <= 1e-12


def test_area_table_starts_at_zero_force() -> None:
    table = TableArea((0.2, 1.5), (0.5e-4, 1.5e-4))
    np.testing.assert_allclose(table.area_m2([0.0, 0.1, 0.2]), [0.0, 0.25e-4, 0.5e-4], atol=1e-18)


def test_a_constant_area_is_none_without_force() -> None:
    np.testing.assert_array_equal(PowerLawArea(exponent=0.0).area_m2([0.0, 1.0]), [0.0, 1e-4])


def test_a_region_ends_at_both_of_its_edges() -> None:
    share = Region(0.01, 0.03).force_share([0.0, 0.01, 0.02, 0.03, 0.04])
    np.testing.assert_array_equal(share, [0.0, 1.0, 1.0, 0.0, 0.0])


def test_second_reversal_starts_from_current_pile() -> None:
    velvet = Velvet(with_pile=0.2, against_pile=1.0, tuft_depth=0.0, reversal_m=2e-3)
    path_m = np.r_[np.linspace(0, 0.05, 501), np.linspace(0.05, 0.049, 11)[1:], np.linspace(0.049, 0.06, 111)[1:]]
    share = velvet.force_share_along(path_m)
    turned = 1 - 0.8 * np.exp(-0.5)
    assert share[510] == pytest.approx(turned, rel=1e-9)
    np.testing.assert_allclose(share[511:], 0.2 + (turned - 0.2) * np.exp(-(path_m[511:] - 0.049) / 2e-3), rtol=1e-9)


def test_pause_does_not_turn_velvet_pile() -> None:
    back_m, velvet = np.linspace(0.05, 0.03, 201), Velvet(tuft_depth=0.0)
    path_m = np.r_[0.0, 0.05, back_m]
    waiting_m = np.r_[path_m[:50], np.full(7, path_m[49]), path_m[50:]]
    found = np.delete(velvet.force_share_along(waiting_m), np.s_[50:57])
    np.testing.assert_allclose(found, velvet.force_share_along(path_m), rtol=1e-14)


def test_noise_has_no_line_at_0() -> None:
    assert Noise.drawn(1e-9, 100.0, 0.1, rng=np.random.default_rng(1)).lines_per_m[0] == pytest.approx(10.0)
