"""Readers of the files that loggers write; one per format."""
