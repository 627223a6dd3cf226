"""What a beating paddle pushes with on average: by theory, and by the formula in use for AQUA."""

from __future__ import annotations

import math

from morph.physics.fluid.thrust import shed_mass


def of_theory(amplitude: float, frequency: float, *, reach: float, span: float) -> float:
    """Return the mean forward force of a paddle on a hull that is held, N.

    With q = A sin(w t) its edge moves across itself at L dq/dt and pulls m (L dq/dt)^2 / 2 along
    the chord, of which cos q points forward; the mean of cos(p)^2 cos(A sin p) is J1(A) / A:

        F = m L^2 w^2 A J1(A) / 2,    m = rho pi / 4 s^2.

    Source: Lighthill 1971, Proc. R. Soc. B 179, the force at the tail where it does not advance.

    Args:
        amplitude: A, rad.
        frequency: w / 2 pi, Hz.
        reach: From the hinge to the edge, L, m.
        span: Length of the edge, s, m.
    """
    from scipy.special import j1

    omega = 2.0 * math.pi * frequency
    mass = shed_mass(span, 1000.0)
    return float(0.5 * mass * reach**2 * omega**2 * amplitude * j1(amplitude))


def of_aqua(
    amplitude: float, frequency: float, *, length: float, widths: tuple[float, float]
) -> float:
    """Return the mean force of an AQUA paddle by the formula of its simulators, N.

        F = 0.1963 (w1 + 2 w2) l^2 / 3 rho A f

    A fit to measured paddles, as its units show. AQUA's Gazebo simulation multiplies it by 5.

    Source: NicholasColotouros/ROS-Localizer at b8d5231, aqua_gazebo/src/aqua_flippers_plugin.cpp,
    which names Giguere, Prahacs and Dudek 2006, Plamondon and Nahon 2009 and Georgiades 2005.

    Args:
        amplitude: A, rad.
        frequency: f, Hz.
        length: l, m.
        widths: At the hip, w1, and at the end, w2, m.
    """
    shape = (widths[0] + 2.0 * widths[1]) * length**2 / 3.0
    return 0.1963 * shape * 1000.0 * amplitude * frequency
