"""One touch on the bench: samples heard, gated, judged; the decision taken in the sensor thread."""
