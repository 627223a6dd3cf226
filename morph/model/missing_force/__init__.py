"""A simulator as the mean of a Gaussian process: its figures and a missing force, together."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
