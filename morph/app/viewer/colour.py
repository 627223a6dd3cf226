"""Colours as the page's lines and arrows want them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from morph.app.viewer.content import Colour


def linear(colour: Colour) -> Colour:
    """Return a colour as lines and arrows want it: they are not taken for sRGB, as meshes are.

    Source: IEC 61966-2-1, with one exponent for its two branches.
    """
    red, green, blue = (round(255.0 * (each / 255.0) ** 2.2) for each in colour)
    return red, green, blue


def linears(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return many colours as corners of meshes want them, shape (..., 3)."""
    return np.rint(255.0 * (colours / 255.0) ** 2.2).astype(np.uint8)
