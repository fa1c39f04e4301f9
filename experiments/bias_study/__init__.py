"""Simulated participants: statuses, coverage and bias of their estimates."""
