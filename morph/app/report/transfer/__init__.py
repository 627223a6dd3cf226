"""The report of a transfer along a chain of bodies."""
