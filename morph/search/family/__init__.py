"""Families of policies: which numbers a search may turn, body by body."""
