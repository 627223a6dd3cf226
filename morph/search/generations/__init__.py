"""Searches that try many policies at once, generation after generation."""
