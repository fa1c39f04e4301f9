"""Finding 3 over the spread of its sources, against scenes and closed forms."""

import numpy as np
import pytest

from tactometry.experiments.thesis import finding_3, force_spread as spread
from tactometry.experiments.thesis.spread import draw

DRAWN = draw(spread.RANGES, spread.N_DRAWS, spread.SEED)


def changed(draws, **values):
    return spread.changes_db(draws | {name: np.full(spread.N_DRAWS, value) for name, value in values.items()})


def effects_of(drawn):
    """Return the built-in scene with the values of one draw."""
    of = {name: value.item() for name, value in drawn.items()}
    damping = of["stiffness_n_per_m"] / (2 * np.pi * of["crossover_hz"])
    pulp = {name: of[name] for name in ("stiffness_n_per_m", "mass_kg", "stiffness_exponent", "damping_exponent")}
    return finding_3.DEFAULT | {
        "contact_area": {"area_at_1n_m2": of["area_at_1n_m2"], "exponent": of["area_exponent"]},
        "friction": {"coefficient": of["coefficient"], "load_exponent": of["load_exponent"]},
        "friction_lag": {"slope_hz_per_m_per_s": of["cutoff_hz"] / spread.SPEED_M_PER_S},
        "skin_mobility": pulp | {"damping_n_s_per_m": damping},
        "body_resistance": {"resistance_ohm": of["body_ohm"]},
        "sensitivity": {"reference_m": of["reference_m"]},
    }


def of_draw(i):
    return {name: values[i : i + 1] for name, values in DRAWN.items()}


@pytest.mark.parametrize("i", range(3))
def test_closed_form_of_a_draw_agrees_with_its_scene(i):
    frequencies_hz = (30.0, 240.0, 480.0)
    built_in_db = {f_hz: finding_3.thresholds_db(finding_3.DEFAULT, f_hz, [1.0])[0] for f_hz in frequencies_hz}
    found_db = spread.thresholds_db(of_draw(i), built_in_db, (0.5, 3.0))
    scene_db = [finding_3.thresholds_db(effects_of(of_draw(i)), f_hz, (0.5, 3.0)) for f_hz in frequencies_hz]
    np.testing.assert_allclose(found_db[0], scene_db, atol=0.05)


def test_central_values_are_those_of_the_built_in_scene():
    built_in_db = dict.fromkeys(spread.FREQUENCIES_HZ, 31.0)
    levels_db = spread.thresholds_db(spread.central(), built_in_db, (0.5, 1.0, 3.0))
    np.testing.assert_allclose(levels_db[0, :, 1], 31.0, atol=1e-12)
    np.testing.assert_allclose(levels_db[0, :, 2] - levels_db[0, :, 0], -10 / 3 * np.log10(6), atol=1e-12)


def test_skin_as_the_radius_of_a_light_contact_changes_alike_at_all_frequencies():
    """Area gains 10 m dB per decade of force, and the skin takes half of it."""
    exponent = 0.6
    of_radius = {"area_exponent": exponent, "stiffness_exponent": exponent / 2, "damping_exponent": exponent / 2}
    found_db = changed(DRAWN, **of_radius, mass_kg=0.0, body_ohm=0.0, load_exponent=0.0)
    np.testing.assert_allclose(found_db, -10 * exponent / 2 * np.log10(6), atol=1e-12)


@pytest.mark.parametrize("name", ["area_at_1n_m2", "coefficient", "cutoff_hz", "reference_m"])
def test_value_without_exponent_changes_no_influence_of_force(name):
    without = DRAWN | {"body_ohm": np.zeros(spread.N_DRAWS)}
    ends = spread.RANGES[name]
    np.testing.assert_allclose(changed(without, **{name: ends.low}), changed(without, **{name: ends.high}), atol=1e-11)


@pytest.mark.parametrize("force_n", [1e-9, 100.0])
@pytest.mark.parametrize("frequency_hz", [0.0, 1e5])
def test_gain_is_finite_at_hard_cases(force_n, frequency_hz):
    assert np.isfinite(spread.gain_db(DRAWN, [frequency_hz], [force_n])).all()


def test_finger_without_force_feels_nothing():
    with np.errstate(divide="ignore"):
        assert (spread.gain_db(spread.central(), [60.0], [0.0]) == -np.inf).all()


def test_each_part_of_a_range_has_one_draw():
    for name, ends in spread.RANGES.items():
        assert ends.source
        values = np.log(DRAWN[name]) if ends.scale == "log" else DRAWN[name]
        low, high = (np.log([ends.low, ends.high])) if ends.scale == "log" else (ends.low, ends.high)
        parts = np.floor((values - low) / (high - low) * spread.N_DRAWS)
        assert sorted(parts) == list(range(spread.N_DRAWS))


@pytest.mark.parametrize(("n_draws", "largest_db"), [(500, 0.32), (2000, 0.16), (8000, 0.08)])
def test_ends_of_the_band_converge_with_the_draws(n_draws, largest_db):
    """The spread between seeds halves with four times the draws."""
    changes_db = [spread.changes_db(draw(spread.RANGES, n_draws, seed)) for seed in range(8)]
    bands_db = np.quantile(changes_db, (0.05, 0.95), axis=1)
    assert np.std(bands_db, axis=1, ddof=1).max() < largest_db


@pytest.fixture(scope="module")
def rows():
    found = {}
    for each in spread.numbers(dict.fromkeys(spread.FREQUENCIES_HZ, 30.0)):
        found.setdefault(each.part, {}).setdefault(each.condition, {})[each.quantity] = each
    return found


def test_outcome_names_the_range_with_the_largest_correlation(rows):
    correlations = rows[spread.CORRELATIONS]
    largest = [
        max(correlations, key=lambda name: abs(correlations[name][f"{f_hz} Hz"].value)) for f_hz in (60, 120, 240, 480)
    ]
    assert largest == [f"exponent of the {part}" for part in ("stiffness", "damping", "damping", "contact area")]


def test_outcome_has_the_shares_and_bands_of_the_draws(rows):
    every, radius = (rows[spread.ABLATION][name] for name in (spread.ALL, spread.MINDLIN))
    at_240 = every["from 0.5 to 3 N, 240 Hz"]
    assert [round(value, 1) for value in (at_240.value, at_240.low, at_240.high)] == [1.8, -2.9, 6.7]
    assert [round(row[f"draws: {spread.BOTH}"].value) for row in (every, radius)] == [2, 28]
    medians = [radius[f"from 0.5 to 3 N, {f_hz} Hz"].value for f_hz in (60, 120, 240, 480)]
    assert max(map(abs, medians[:3])) < 0.3
    assert round(medians[3], 1) == -0.4
    assert not every[f"draws: {spread.BOTH}"].holds
