"""What electrovibration says of itself is so: each claim against the force or the motion that it speaks of."""

import re

import numpy as np
import pytest

from tactometry.stimuli.electrovibration import (
    LAWS,
    Layer,
    Sine,
    Skin,
    Step,
    WithOffset,
    electrostatic_force_n_at,
)

P0, AREA_M2 = Skin(), 1e-4
TONE = WithOffset(Sine(frequency_hz=60.0), ratio=0.5)
SKINS = [
    P0,
    Skin(body_resistance_ohm=1e4),
    Skin(body_resistance_ohm=1e6),
    Skin(tissue=Layer(5e-3, 1e4, 2.0)),
    Skin(gap_m=2e-6, body_resistance_ohm=1e5),
]


def remarked_s(remark: str) -> float:
    found = re.search(r"\((\S+) ms\)", remark)
    assert found is not None
    return 1e-3 * float(found[1])


def force_after_a_step_n(skin: Skin, law: str, t_s) -> np.ndarray:
    pieces = Step(duration_s=100.0, rate_hz=10.0).pieces(40.0)
    return electrostatic_force_n_at(t_s, pieces, skin=skin, area_m2=AREA_M2, law=law)


@pytest.mark.parametrize("skin", SKINS)
def test_where_an_offset_is_said_to_be_blocked_its_force_has_gone(skin: Skin) -> None:
    remark = TONE.remark(skin, "sc_layer", AREA_M2)
    assert remark is not None
    assert "blocks" in remark
    after_s = remarked_s(remark)
    peak_n = force_after_a_step_n(skin, "sc_layer", np.linspace(0, after_s, 5001)).max()
    left_n = force_after_a_step_n(skin, "sc_layer", after_s * np.array([1.0, 1.5, 3.0]))
    assert (left_n < 0.01 * peak_n).all()
    assert force_after_a_step_n(skin, "sc_layer", 0.2 * after_s) > 0.01 * peak_n


@pytest.mark.parametrize("skin", SKINS)
def test_where_an_offset_is_said_to_stay_its_force_has_risen(skin: Skin) -> None:
    remark = TONE.remark(skin, "interface", AREA_M2)
    assert remark is not None
    assert "keeps" in remark
    after_s = remarked_s(remark)
    t_s = after_s * np.array([0.0, 0.2, 1.0, 50.0])
    start_n, early_n, then_n, last_n = force_after_a_step_n(skin, "interface", np.minimum(t_s, 99.0))
    assert start_n < 0.95 * last_n
    assert early_n < then_n
    assert then_n == pytest.approx(last_n, rel=0.02)


@pytest.mark.parametrize("law", LAWS)
def test_without_a_remark_the_force_of_a_constant_does_not_change(law: str) -> None:
    skin = P0 if law in ("total_thickness", "parallel_plate") else Skin(corneum_resistivity_ohm_m=np.inf)
    assert TONE.remark(skin, law) is None
    first_n, last_n = force_after_a_step_n(skin, law, [1e-6, 50.0])
    assert first_n == pytest.approx(last_n, rel=1e-12)
    assert first_n > 0
