"""The course of one trial, a file per task."""
