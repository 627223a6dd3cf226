"""Maps between bodies, from arrays and callables alone; the maps are still to come."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
