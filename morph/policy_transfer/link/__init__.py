"""A policy that keeps adapting although the way to its service is often closed."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
