"""Recordings: what a robot did, in SI units and on one clock."""
