"""Durable records on disk: journal and data set."""
