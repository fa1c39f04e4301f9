"""Tests of the figures of touches."""

import numpy as np
import pandas as pd

from tactometry.analysis.figures.touches import courses_figure


def test_courses_of_motionless_finger_are_drawn():
    """All speeds are 0; an axis from 0 to 0 caused a warning."""
    course = {"time_s": np.linspace(-0.1, 0.5, 5), "low": 0.0, "median": 0.0, "high": 0.0}
    asked = {"participant": "P01", "quantity": "speed_m_per_s", "target": 0.0, "band_low": np.nan, "band_high": np.nan}
    assert courses_figure(pd.DataFrame({**asked, **course}), "speed_m_per_s").png()
