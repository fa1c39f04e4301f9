"""The course of one trial, in one file per task."""
