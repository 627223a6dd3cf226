"""The files that a film can be written to; light, so that a wrong one is told at once."""

from __future__ import annotations

FILMS = {".mp4": (30.0, (1280, 720)), ".gif": (25.0, (640, 360))}
"""Pictures a second and their size; a GIF's pictures last whole hundredths of a second."""
