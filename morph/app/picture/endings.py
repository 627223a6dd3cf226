"""The files that films and pictures can be written to; light: a wrong one is told at once."""

from __future__ import annotations

FILMS = {".mp4": (30.0, (1280, 720)), ".gif": (25.0, (640, 360))}
"""Pictures a second and their size; a GIF's pictures last whole hundredths of a second."""
PICTURES = {".png": (1280, 720)}
"""Width and height of one picture."""
