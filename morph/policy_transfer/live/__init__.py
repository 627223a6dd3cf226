"""Trials on what really moves: a callable or a process as a target, watched and held safe."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
