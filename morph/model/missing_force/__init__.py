"""A simulator as the mean of a Gaussian process: its figures and a missing force, together."""
