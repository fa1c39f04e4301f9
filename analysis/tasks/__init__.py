"""Analyses of tasks, one file per task as in protocols/tasks."""
