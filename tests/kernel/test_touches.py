"""Touches computed in batches equal those from each trial's stream."""

import numpy as np
from hypothesis import given, strategies as st

from tactometry.gates import compliance, motion
from tactometry.observers.finger import N_AHEAD, SimulatedFinger, Touches
from tactometry.session.request import Press, Slide

FINGER = SimulatedFinger(force_factor=1.1, speed_factor=0.9)
PRESS = Press("tone", 20.0, 0.3, 1.0, 0.2, 0.5, 5.0)
SHORT = Press("tone", 20.0, 0.1, 2.0, 0.01, 0.5, 5.0)
SLIDE = Slide("tone", 20.0, 0.3, 1.0, 0.2, 0.5, 5.0, 0.05)
GATED = Slide("tone", 20.0, 0.3, 1.0, 0.2, 0.5, 5.0, 0.05, speed_tolerance=0.2)
QUESTION = "question"
STEPS = st.sampled_from([PRESS, SHORT, SLIDE, GATED, QUESTION])


def stream(n_trials):
    return np.random.default_rng([7, n_trials])


def facts_of(touch):
    grip = touch.grip
    return grip.forces_n.tolist(), grip.positions_m.tolist(), grip.speed_m_per_s, touch.force, touch.speed


def one_by_one(request, rng):
    grip = FINGER.hold(request, rng)
    force = compliance(grip.times_s, grip.forces_n, request.target_n, request.tolerance)
    is_gated = isinstance(request, Slide) and request.speed_tolerance is not None
    speed = motion(grip.times_s, grip.positions_m, request.speed_m_per_s, request.speed_tolerance) if is_gated else None
    return grip.forces_n.tolist(), grip.positions_m.tolist(), grip.speed_m_per_s, force, speed


@given(st.lists(st.lists(STEPS, max_size=4), max_size=6))
def test_each_trial_draws_from_its_own_stream(trials):
    touches = Touches(FINGER, stream)
    for n, steps in enumerate(trials):
        touches.begin(n)
        rng = stream(n)
        for step in steps:
            if step is QUESTION:
                assert touches.rng.random() == rng.random()
            else:
                assert facts_of(touches.touch(step)) == one_by_one(step, rng)
        assert touches.rng.random() == rng.random()


def test_each_stream_is_made_once():
    made = []
    touches = Touches(FINGER, lambda n: made.append(n) or stream(n))
    for n in range(3 * N_AHEAD):
        touches.begin(n)
        assert facts_of(touches.touch(SLIDE if n % 20 < 10 else GATED)) == one_by_one(
            SLIDE if n % 20 < 10 else GATED, stream(n)
        )
        touches.rng.random()
    assert sorted(made) == list(range(len(made)))
