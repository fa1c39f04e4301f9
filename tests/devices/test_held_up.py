"""Unreported gaps of a sound card, found from recorded request times."""

import pytest

from tactometry.devices.outputs.frame_feed import DryRuns, was_held_up

LATENCY_S, BLOCK_S, DURATION_S = 0.1, 0.005, 0.3
"""Of the recorded touches, on two cores."""

TORN = {
    "1.5 ms are missing at 270 ms": [
        (-0.0749, 0.1050, 6), (-0.0252, 0.0859, 6), (-0.0221, 0.1129, 6), (0.0272, 0.0960, 6), (0.0385, 0.1148, 6),
        (0.1124, 0.0721, 12), (0.1508, 0.0942, 6), (0.1908, 0.0848, 6), (0.2672, 0.0400, 18), (0.3051, 0.0825, 6),
    ],
    "20 ms of silence at 30 ms, which were written 86 ms before": [
        (-0.1772, 0.0871, 6), (-0.1117, 0.0517, 12), (-0.0711, 0.0711, 6), (-0.0336, 0.0636, 12), (0.0185, 0.0716, 6),
        (0.0618, 0.0772, 6), (0.1119, 0.0571, 12), (0.1745, 0.0552, 12), (0.2340, 0.0560, 12), (0.2626, 0.0884, 6),
    ],
    "20 ms of silence at 30 ms, which were never in hand": [
        (-0.1446, 0.0846, 6), (-0.1177, 0.0877, 6), (-0.0977, 0.0977, 6), (0.0022, 0.0279, 12), (0.0544, 0.0357, 6),
        (0.0976, 0.0225, 6), (0.1383, 0.0525, 12), (0.1664, 0.0963, 6), (0.1984, 0.0943, 6), (0.2144, 0.1083, 6),
    ],
}  # fmt: skip
"""Bursts of requested blocks: time (s after the onset), lead stated by the card (s), number of blocks. None had a
reported underflow."""

AT_LEISURE = [
    (-0.0954, 0.0954, 6), (-0.0754, 0.1053, 6), (-0.0353, 0.0953, 6), (-0.0153, 0.1053, 6), (0.0247, 0.0953, 6),
    (0.0447, 0.1052, 6), (0.0848, 0.0952, 6), (0.1099, 0.1000, 6), (0.1449, 0.0951, 6), (0.1649, 0.1051, 6),
    (0.2083, 0.0917, 6),
]  # fmt: skip
"""Bursts of a touch without a gap, when the process and its server had priority."""


def torn_from_s(bursts, latency_s=LATENCY_S):
    dry = DryRuns(latency_s)
    blocks = [(now_s, lead_s + k * BLOCK_S) for now_s, lead_s, n_blocks in bursts for k in range(n_blocks)]
    begun_s = [dry.after(now_s=now_s, lead_s=lead_s, block_s=BLOCK_S, underflow=False) for now_s, lead_s in blocks]
    return [began_s for began_s in begun_s if began_s is not None]


@pytest.mark.parametrize("heard", TORN)
def test_silent_gaps_are_found_from_request_times(heard):
    assert any(began_s < DURATION_S for began_s in torn_from_s(TORN[heard]))


def test_punctual_card_has_no_gap():
    assert torn_from_s(AT_LEISURE) == []


def test_gap_begins_when_the_late_card_asks():
    (began_s,) = torn_from_s([*AT_LEISURE, (0.2842, 0.0458, 12)])
    assert began_s == pytest.approx(0.2842)


def test_card_with_short_usual_lead_has_no_gap():
    """A card that rounds its latency may always have half of its lead."""
    assert torn_from_s([(0.03 * n, 0.055, 6) for n in range(100)]) == []
    assert not was_held_up(0.055, [0.055] * 400, LATENCY_S)
    assert was_held_up(0.03, [0.055] * 400, LATENCY_S)


def test_long_usual_lead_is_judged_by_requested_latency():
    assert not was_held_up(0.3, [1.0] * 400, LATENCY_S)
    assert was_held_up(0.05, [1.0] * 400, LATENCY_S)


def test_card_without_history_was_not_held_up():
    assert not was_held_up(0.0, [], LATENCY_S)
