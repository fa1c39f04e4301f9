"""Analyses of tasks by participant and condition, one file per task as in protocols/tasks."""
