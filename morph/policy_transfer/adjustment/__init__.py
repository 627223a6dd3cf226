"""A policy adjusted so that a target does under it what the source did: thesis section 3.3."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
