"""Learning the accelerations of a jointed body from control periods."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy.optimize import minimize

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.jointed.jointed import Accelerations, Jointed, through
from morph.model.jointed.kernel import KernelInputs, KernelLayout, Scales, gram
from morph.model.jointed.landmarks import landmarks
from morph.model.jointed.part import AccelerationModel
from morph.model.jointed.transition import JointTransitions

JITTER = 1e-6
"""Variance added to that of the noise, of accelerations in units of their size."""

FEW, MANY = 240, 800
"""Most periods from which the kernel's settings are learned, and with them the accelerations."""

AROUND = 300
"""Postures for each turning joint, among which landmarks are chosen beside those seen."""

FREE_GAIN = 2.0
"""Gain in log evidence below which the free part of an acceleration is left out."""


@dataclass(frozen=True, kw_only=True)
class JointedSettings:
    """What a body's model begins with."""

    turning: tuple[int, ...]
    """The joints whose positions are angles."""
    sliding: tuple[int, ...] = ()
    """The slides whose positions matter, as springs and stops make them."""
    command_size: tuple[float, ...]
    """A natural size of each command: its bound."""
    lawful: bool = True
    """Whether accelerations are known to be quadratic in velocities and affine in commands."""
    names: tuple[str, ...] = ()
    """What the joints are called, for messages; by their numbers without."""


def fit(
    data: JointTransitions,
    settings: JointedSettings,
    before: Array | None = None,
    base: Accelerations | None = None,
) -> Jointed:
    """Return the accelerations that periods show.

    The mean acceleration of a period is first taken for that in its middle. Then the model
    itself is stepped through each period, and what it misses of the change in velocity is added
    to its acceleration in the middle: deferred correction, which makes the model right for
    whole periods and not only for short ones.

    Args:
        data: The periods.
        settings: What is known of the body.
        before: Logarithms of a model's settings, shape (joints, settings), from which the search
            begins; those of a model of fewer periods save steps.
        base: What is believed of the accelerations before the periods: the mean of the
            processes, of which only what it misses is learned; None for zero.

    Raises:
        SearchError: A joint never moved, or its accelerations cannot be told apart.
    """
    data = data.thinned(MANY)
    few = data.thinned(FEW)
    model = _empty(data, settings, before, base)
    for part, steps in ((few, 60), (few, 30), (data, 0)):
        aimed = _corrected(model, part) if model.parts else torch.as_tensor(part.acceleration)
        model = _solved(_settled(_shown(model, part, aimed), steps))
    return model


def _empty(
    data: JointTransitions,
    settings: JointedSettings,
    before: Array | None,
    base: Accelerations | None,
) -> Jointed:
    """Return a model that has its units from the data, but has not seen them yet."""
    joints = data.position.shape[1]
    _check_moved(torch.as_tensor(data.acceleration.std(axis=0)), data, settings.names)
    # With a base the unit is that of what it misses.
    size = _missed(torch.as_tensor(data.acceleration), data, base).numpy().std(axis=0)
    layout = KernelLayout(
        turning=settings.turning,
        sliding=settings.sliding,
        joints=joints,
        commands=data.command.shape[1],
        lawful=settings.lawful,
    )
    none = torch.zeros(0, joints, dtype=torch.float64)
    return Jointed(
        layout=layout,
        logs=layout.prior[0].repeat(joints, 1) if before is None else torch.as_tensor(before),
        parts=(),
        seen=KernelInputs(place=none, velocity=none, command=none),
        target=none,
        velocity_size=torch.as_tensor(data.velocity.std(axis=0) + 1e-9),
        command_size=torch.as_tensor(np.asarray(settings.command_size, dtype=float)),
        size=torch.as_tensor(np.maximum(size, 1e-9)),
        period=data.period,
        base=base,
    )


def _shown(model: Jointed, data: JointTransitions, acceleration: torch.Tensor) -> Jointed:
    """Return the model with other data, not conditioned on them yet; (n, joints)."""
    q, v, u = (torch.as_tensor(a) for a in (*data.middle, data.command))
    target = _missed(acceleration, data, model.base) / model.size
    return replace(model, seen=model.look(q, v, u), target=target)


def _missed(
    acceleration: torch.Tensor, data: JointTransitions, base: Accelerations | None
) -> torch.Tensor:
    """Return what a base misses of accelerations in the middle of periods, (n, joints)."""
    if base is None:
        return acceleration
    with torch.no_grad():
        return acceleration - base(*(torch.as_tensor(a) for a in (*data.middle, data.command)))


def _corrected(model: Jointed, data: JointTransitions) -> torch.Tensor:
    """Return accelerations in the middle that a step of the model misses nothing with."""
    q, v, u = (torch.as_tensor(a) for a in (*data.middle, data.command))
    begin = torch.as_tensor(data.position), torch.as_tensor(data.velocity)
    _, came = through(model.mean, *begin, u, data.period)
    missed = (torch.as_tensor(data.next_velocity) - came) / data.period
    return model.mean(q, v, u) + missed


def _check_moved(size: torch.Tensor, data: JointTransitions, names: tuple[str, ...]) -> None:
    still = [at for at, each in enumerate(size.tolist()) if not each > 1e-9]
    if still:
        which = f"{names[still[0]]!r}" if names else f"number {still[0]}"
        raise SearchError(
            f"joint {which} kept its velocity through all {len(data.command)} periods",
            where="the periods to learn from",
            fix="give a first trial that moves every joint: larger or longer random commands",
        )


def _settled(model: Jointed, steps: int) -> Jointed:
    """Return the model with the likeliest settings under their prior."""
    if not steps:
        return model
    middle, spread = model.layout.prior
    shape = model.logs.shape

    def unlikeliness(vector: Array) -> tuple[float, Array]:
        logs = torch.tensor(vector.reshape(shape), requires_grad=True)
        total = 0.5 * (((logs - middle) / spread) ** 2).sum()
        for at in range(model.layout.joints):
            total = total - log_evidence(model, at, model.layout.scales(logs[at]))
        (slope,) = torch.autograd.grad(total, logs)
        return float(total.detach()), slope.numpy().ravel()

    # Not torch's own search: that imports a compiler, which takes seconds.
    result = minimize(
        unlikeliness,
        model.logs.numpy().ravel(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": steps},
    )
    return replace(model, logs=torch.as_tensor(result.x.reshape(shape)))


def log_evidence(model: Jointed, at: int, scales: Scales) -> torch.Tensor:
    """Return log p(accelerations of one joint | settings) but for its constant.

    Source: Rasmussen and Williams 2006, eq. 2.30.
    """
    covariance = gram(model.layout, scales, model.seen, model.seen)
    factor = _factor(covariance, scales)
    weight = torch.cholesky_solve(model.target[:, at : at + 1], factor)[:, 0]
    fits = 0.5 * (model.target[:, at] * weight).sum()
    evidence: torch.Tensor = -fits - torch.log(torch.diagonal(factor)).sum()
    return evidence


def _factor(covariance: torch.Tensor, scales: Scales) -> torch.Tensor:
    noise = (scales.noise**2 + JITTER) * torch.ones(len(covariance), dtype=torch.float64)
    factor: torch.Tensor = torch.linalg.cholesky(covariance + torch.diag(noise))
    return factor


def _solved(model: Jointed) -> Jointed:
    """Return the model conditioned on its targets, without free parts that earn nothing."""
    places = _places(model)
    parts = []
    for at in range(model.layout.joints):
        scales = model.layout.scales(model.logs[at])
        if model.layout.lawful:
            bound = replace(scales, free=torch.zeros_like(scales.free))
            gain = log_evidence(model, at, scales) - log_evidence(model, at, bound)
            scales = scales if gain > FREE_GAIN else bound
        empty = torch.zeros(0, dtype=torch.float64)
        part = AccelerationModel(
            scales=scales,
            postures=landmarks(places / scales.place),
            factor=empty,
            coefficient=empty,
            data=empty,
            weight=empty,
        )
        covariance = part.covariance(model.layout, model.seen, model.seen)
        part = replace(part, factor=_factor(covariance, scales), data=part.freely(model.seen))
        parts.append(part.conditioned(model.layout, model.seen, model.target[:, at]))
    return replace(model, parts=tuple(parts))


def _places(model: Jointed) -> torch.Tensor:
    """Return the places that were seen, and others all around, among which landmarks are chosen."""
    layout, seen = model.layout, model.seen.place
    turning = len(layout.turning)
    if not turning:
        return seen
    # Any even spread does; the chance is the same each time, so that models are too.
    rng = np.random.default_rng(0)
    angle = torch.as_tensor(rng.uniform(-np.pi, np.pi, (AROUND * turning, turning)))
    slide = seen[torch.as_tensor(rng.integers(0, len(seen), len(angle)))][:, 2 * turning :]
    around = torch.cat([torch.cos(angle), torch.sin(angle), slide], dim=-1)
    return torch.cat([around, seen])
