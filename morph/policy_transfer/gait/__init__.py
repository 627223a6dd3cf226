"""Gaits carried from body to body: patterns, and what learns where each actuator belongs."""
