"""The thesis' swimmer: its water, its gaits, and how it is steered."""
