"""Policies near a policy: what a search that only tries may change of it."""
