"""Optimal trajectories: differential dynamic programming on many of them at once."""
