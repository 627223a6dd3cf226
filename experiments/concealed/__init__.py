"""Benchmark: name the physics that a robot's description leaves out, from plain files."""
