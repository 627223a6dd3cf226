"""Models of what was recorded: screening, fitting, choosing, and the finding in words."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
