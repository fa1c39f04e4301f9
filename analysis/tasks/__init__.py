"""One estimate per participant and condition, a file per task, as in protocols/tasks."""
