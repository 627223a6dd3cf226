"""Baselines of transfer: other ways to use a source, and none."""
