"""Time window of a recording with each model's prediction of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from morph.app.viewer.content import Colour
from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import Effect

DESCRIBED, CORRECTED = "described", "corrected"
"""The models: the description as it was given, and as the diagnosis put it right."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MismatchModel:
    """One account of the robot."""

    name: str
    """`described` or `corrected`."""
    title: str
    """What legends call it."""
    robot: Robot
    """Its description."""
    effects: tuple[Effect, ...]
    """What acts on it."""
    colour: Colour
    """Of its ghost, its lines and its arrows."""

    @property
    def css(self) -> str:
        """Its colour as CSS has it."""
        return "#" + "".join(f"{part:02x}" for part in self.colour)


@dataclass(frozen=True, kw_only=True)
class Ask:
    """What is to be shown."""

    episode: int = 0
    """Number of the recording."""
    window: int = 0
    """Number of its window."""
    horizon: float | None = None
    """Seconds after which the simulation is restarted from the recording; None for never."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MismatchTrace:
    """One channel as it was read and as the models have it."""

    channel: str
    """Its name, from a file."""
    unit: str
    """Of its values."""
    link: str
    """The link that it tells of."""
    time: Array
    """Since the window began, s, shape (readings,); NaN between one rollout and the next."""
    measured: Array
    """Readings; same shape."""
    simulated: Mapping[str, Array]
    """By model; same shape each."""
    noise: float
    """Standard deviation of the readings' noise."""
    rmse: Mapping[str, float]
    """Root mean square error over the rollouts shown, by model."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Missing:
    """The generalized force that a model lacks along the recording."""

    time: Array
    """Since the window began, s, shape (samples,)."""
    force: Array
    """N m or N, shape (samples, joints); what a push at each joint would have to add."""
    share: Mapping[str, Array] = field(default_factory=dict)
    """What each finding's effect makes of it: its own force times the one missing, by the
    effect's label, shape (samples,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Take:
    """A window of one recording."""

    ask: Ask
    """What was asked for."""
    name: str
    """The recording's name."""
    start: float
    """When the window begins, s from the recording's start."""
    seconds: float
    """How long it is."""
    horizon: float | None
    """After how many seconds the simulation is restarted; None for never."""
    measured: Array
    """Poses as recorded, `qpos` in the pictures, shape (pictures, nq)."""
    simulated: Mapping[str, Array]
    """Poses by model; same shape each."""
    traces: tuple[MismatchTrace, ...]
    """In the order of the joints."""
    missing: Mapping[str, Missing] = field(default_factory=dict)
    """By model; none where it cannot be told."""
    worst: tuple[tuple[float, float], ...] = ()
    """The worst stretches in the window, from and to, s since it began, worst first."""
    notes: tuple[str, ...] = ()
    """What is to be known of it."""
