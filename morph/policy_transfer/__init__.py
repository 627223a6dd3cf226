"""Policies carried to another body: the loop, live targets, and the link to a service."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
