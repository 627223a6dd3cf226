"""The disturbance under which a smoothed run is likeliest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import OptimizeResult, minimize

from morph.arrays import Array
from morph.inference.filter import Disturbance, scored
from morph.inference.sampled import FLOOR, Reference
from morph.inference.whitened import whitened

CORRELATION_TIMES = (0.05, 2.0)
"""Bounds of the missing force's correlation time, s: a stroke of a servo, the drift of a run."""
NOISE_FACTORS = (0.1, 3.0)
"""Bounds of the factor of the noise that the channels are known for."""
VIBRATIONS = (0.05, 300.0)
"""Bounds of each channel's vibration, as factors of its known noise."""
MOST_SCALE = 30.0
"""Most scale of the missing force, as a share of the RMS force that a joint's motion needs."""
MOST_UNREAD = 0.1
"""The same at a joint that was not read: more would let it move in any way."""
FORCED = 0.3
"""Missing force as a share of the RMS force that a joint's motion needs, from which one search
starts."""
CONTACT, CONTACT_TIMES = (1e-3, 1e4), (1e-3, 10.0)
"""Bounds of the standard deviation of the mass-weighted acceleration of points in contact,
sqrt(J)/s, and of its correlation time, s: a knock, or a run that stands."""
NUDGE = 1e-3
"""Finite-difference step of the logarithms of correlation times."""
MOST_SAMPLES, LEAST_SAMPLES, DOFS = 1500, 300, 12
"""Samples of a run by which its disturbance is judged, and from how many degrees of freedom on they
are fewer, as one over their square: the time of each grows with their cube."""


def likeliest_disturbance(about: Reference, *, steps: int) -> Disturbance:
    """Return the disturbance of greatest likelihood: all its scales, times and the noise.

    A second or a few from the middle of a run stand for all of it.

    Source: Rasmussen and Williams 2006, section 5.4.1 (the marginal likelihood).

    Args:
        about: The motion; its disturbance is where the search starts.
        steps: Most steps of L-BFGS.
    """
    few = MOST_SAMPLES * (DOFS / max(DOFS, about.velocity.shape[1])) ** 2
    whole, about = about.disturbance, _middle(about, max(LEAST_SAMPLES, int(few)))
    first, tangent = about.disturbance, about.tangent
    dofs = len(first.scale)
    # Vibration displaces what is read of positions.
    sensed = about.sensed[:dofs]

    def at(point: Array) -> Disturbance:
        return replace(
            first,
            scale=about.inertial * np.exp(point[:dofs]),
            vibration=sensed * np.exp(point[dofs:-4]),
            contact=float(np.exp(point[-4])),
            contact_time=float(np.exp(point[-3])),
            correlation_time=float(np.exp(point[-2])),
            noise=about.sensed * np.exp(point[-1]),
        )

    def cost(point: Array) -> float:
        return -log_likelihood(about, at(point))

    def slope(point: Array) -> tuple[float, Array]:
        result = scored(tangent, at(point), about.error, about.acceleration)
        by_times = [
            -(cost(point + NUDGE * axes[at]) + result.log_likelihood) / NUDGE if there else 0.0
            for at, there in ((-3, tangent.contacts), (-2, True))
        ]
        return -result.log_likelihood, -np.array(
            [*result.scale, *result.vibration, result.contact, *by_times, result.noise]
        )

    most = np.where(about.unread, MOST_UNREAD, MOST_SCALE)
    limits = [*((FLOOR, each) for each in most), *[VIBRATIONS] * dofs]
    bounds = np.log([*limits, CONTACT, CONTACT_TIMES, CORRELATION_TIMES, NOISE_FACTORS])
    axes = np.eye(len(bounds))
    vibration = sensed if first.vibration is None else first.vibration
    start = np.log(
        [
            *(first.scale / about.inertial),
            *(vibration / sensed),
            max(first.contact, CONTACT[0]),
            first.contact_time,
            first.correlation_time,
            first.noise[0] / about.sensed[0],
        ]
    )
    # Once an effect is explained less force is missing: a few steps alone would not go that far.
    of_force, of_vibration = np.arange(len(start)) < dofs, np.arange(len(start)) >= dofs
    of_vibration[-4:] = False
    shares = [np.log(share) * of_force for share in (1.0, 0.3, 0.1)]
    shares += [np.log(share) * of_vibration for share in (0.1, 10.0)]
    near = min((np.clip(start + share, *bounds.T) for share in shares), key=cost)

    def descended(begin: Array) -> OptimizeResult:
        options = {"maxiter": steps}
        return minimize(slope, begin, jac=True, method="L-BFGS-B", bounds=bounds, options=options)

    best = descended(near)
    if best.x[dofs:-4].max() > 0.0:
        # Where all is called vibration, more force explains nothing at first: start from force too.
        few = [max(first.contact, CONTACT[0]), first.contact_time, 0.2, 1.0]
        forced = np.log([*[FORCED] * dofs, *[VIBRATIONS[0]] * dofs, *few])
        best = min(best, descended(forced), key=lambda each: float(each.fun))
    return replace(at(best.x), jolt=whole.jolt)


def log_likelihood(about: Reference, disturbance: Disturbance) -> float:
    """Return the log likelihood of the readings under a disturbance, nats."""
    read, moved = about.error[:, :, None], -about.acceleration[:, :, None]
    return whitened(about.tangent, disturbance, read, moved).log_likelihood()


def _middle(about: Reference, samples: int) -> Reference:
    """Return the middle samples of a run."""
    first = max(0, (len(about.velocity) - samples) // 2)
    part, known = slice(first, first + samples), about.disturbance
    tangent = about.tangent
    return replace(
        about,
        position=about.position[part],
        velocity=about.velocity[part],
        force=about.force[part],
        acceleration=about.acceleration[part],
        error=about.error[part],
        tangent=replace(tangent, jacobian=tangent.jacobian[part], valid=tangent.valid[part]),
        disturbance=replace(known, jolt=None if known.jolt is None else known.jolt[part]),
    )
