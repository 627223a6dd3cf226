"""Trials on what really moves: a callable or a process as a target, watched and held safe."""
