"""Gaussian processes: what is foreseen, and the settings that fit the data."""
