"""Searches: from a task and a simulator, or from trials alone, to a policy."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
