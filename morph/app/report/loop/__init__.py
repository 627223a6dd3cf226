"""The report of `morph loop`."""
