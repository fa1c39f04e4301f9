"""Estimates for each participant and condition, a file per task, as in protocols/tasks."""
