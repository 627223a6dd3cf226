"""Regulators: feedback that holds a body where it can rest."""
