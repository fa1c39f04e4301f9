"""Validate procedures, fits and tests against known ground truth."""
