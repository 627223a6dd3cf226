"""The report of an alignment: which part of a body is which of another."""
