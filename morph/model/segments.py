"""Episodes cut into short rollouts that start along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.errors import DiagnosisError
from morph.model.episodes import Episode
from morph.model.measurement import Measurement, unit
from morph.sim.tangent import Coordinates

EDGE = 0.15
"""Seconds at the start of a held-out run in which no scored rollout starts, if it lasts longer than
the horizon by as much."""
QUICK = 5.0
"""Rate, 1/s, at which a joint that was not read may move by as much as its guess is off."""
MOST_SCORED = 240
"""Held-out rollouts; of longer recordings an even spread is scored."""


@dataclass(frozen=True, kw_only=True)
class Segments:
    """Rollouts of one length, each with the readings that fall into it."""

    measurement: Measurement
    """What the readings are of."""
    episodes: tuple[Episode, ...]
    """Where they were cut from."""
    episode: Integers
    """Index of each segment's episode, shape (segments,)."""
    first: Integers
    """The step at which each starts, shape (segments,)."""
    steps: int
    """How many steps each lasts."""
    before: Integers
    """Step before each reading, from the segment's start, shape (segments, readings)."""
    part: Array
    """How far towards the next step each reading lies, 0 to 1; same shape."""
    valid: Mask
    """Which readings exist; rows are padded; shape (segments, readings, channels)."""
    reading: Array
    """What each channel reads, shape (segments, readings, channels)."""
    attitude: Array
    """Measured orientations, shape (segments, readings, balls, 4)."""
    start: Array
    """Estimated start, positions then velocities as measured, shape (segments, nq + nv)."""
    start_trust: Array
    """One over the variance of each start's entry, shape (2 nv,)."""
    noise: Array
    """Standard deviation of the readings' noise, shape (channels,)."""
    guess: Array
    """Standard deviation of the starting positions of joints that were not read, else 0, (nv,)."""

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.first)

    @property
    def step(self) -> float:
        """Seconds a step."""
        return self.episodes[0].step

    @property
    def counts(self) -> Integers:
        """How many readings each segment has of each channel, at least 1, (segments, channels)."""
        return np.asarray(np.maximum(self.valid.sum(axis=1), 1))

    @property
    def read(self) -> Integers:
        """Indices of the channels that were read at all."""
        return np.flatnonzero(self.valid.any(axis=(0, 1)))

    def moved(self, start: Array, change: Array) -> Array:
        """Return starts after a change of positions and velocities, shape (segments, nq + nv).

        Args:
            start: Shape (segments, nq + nv).
            change: Shape (segments, 2 nv).
        """
        space = self.measurement.coordinates
        position, velocity = start[:, : space.positions], start[:, space.positions :]
        moved = space.moved_by(position, change[:, : space.dofs])
        return np.concatenate([moved, velocity + change[:, space.dofs :]], axis=1)

    def grown(self, entry: int, later: Array) -> Array:
        """Return by how much an entry of each smoothed start changes by a later time.

        Args:
            entry: Its index.
            later: How much later, s, shape (segments,).
        """
        result = np.zeros(len(self))
        for row in np.flatnonzero(later):
            whole = self.episodes[int(self.episode[row])]
            begin = float(self.first[row]) * self.step
            if entry >= self.measurement.coordinates.positions:
                begin -= 0.5 * self.step
            now, then = np.interp([begin, begin + later[row]], whole.time, whole.state[:, entry])
            result[row] = then - now
        return result

    def change(self, start: Array, origin: Array) -> Array:
        """Return what leads from some starts to others, shape (segments, 2 nv)."""
        space = self.measurement.coordinates
        places = space.apart(start[:, : space.positions], origin[:, : space.positions])
        rates = start[:, space.positions :] - origin[:, space.positions :]
        return np.concatenate([places, rates], axis=1)

    def seconds(self, index: int) -> tuple[float, float]:
        """Return when a segment starts and ends within its episode, s."""
        start = float(self.first[index]) * self.step
        return start, start + self.steps * self.step

    def only(self, rows: Integers) -> Segments:
        """Return some of the segments."""
        return replace(
            self,
            episode=self.episode[rows],
            first=self.first[rows],
            before=self.before[rows],
            part=self.part[rows],
            valid=self.valid[rows],
            reading=self.reading[rows],
            attitude=self.attitude[rows],
            start=self.start[rows],
        )

    def command(self, commands: Sequence[Array]) -> Array:
        """Return each segment's part of its episode's command, (segments, steps, actuators)."""
        return np.stack(
            [commands[e][f : f + self.steps] for e, f in zip(self.episode, self.first, strict=True)]
        )


def cut(
    episodes: Sequence[Episode],
    horizon: float | None,
    *,
    most: int | None = None,
    skip: float = 0.0,
) -> Segments:
    """Cut episodes into rollouts of `horizon` seconds end to end; None takes them whole.

    Whole episodes of unequal length are cut to the shortest.

    Args:
        episodes: What to cut.
        horizon: Seconds each.
        most: If there are more segments, keep this many, evenly spread.
        skip: Seconds at the start of each episode in which no rollout starts, unless
            episodes are taken whole: smoothing knows a motion poorly where it begins.

    Raises:
        DiagnosisError: No episode is as long as the horizon.
    """
    step = episodes[0].step
    shortest = min(len(e.command) for e in episodes)
    steps = shortest if horizon is None else round(horizon / step)
    where = [
        (index, first)
        for index, e in enumerate(episodes)
        for first in range(round(skip / step), len(e.command) - steps + 1, steps)
    ]
    if horizon is None:
        where = [(index, 0) for index in range(len(episodes))]
    if not where:
        longest = max(float(e.time[-1]) for e in episodes)
        raise DiagnosisError(
            f"rollouts of {steps * step:g} s are longer than the {longest:.3g} s to predict",
            where=", ".join(e.name for e in episodes),
            fix="ask for a shorter --horizon, or record for longer: without --held-out a quarter "
            "is set aside to be predicted",
        )
    if most is not None and len(where) > most:
        where = [where[i] for i in np.linspace(0, len(where) - 1, most).round().astype(int)]
    return _segments(episodes, where, steps)


def scored_segments(episodes: Sequence[Episode], horizon: float | None) -> Segments:
    """Return the rollouts on which models are scored; see `cut` for what it takes and raises."""
    shortest = min(len(e.command) for e in episodes) * episodes[0].step
    spare = 0.0 if horizon is None else shortest - horizon
    # A run that has room for one rollout is scored at its end.
    skip = 0.0 if spare < EDGE else spare if spare < 2.0 * EDGE else EDGE
    return cut(episodes, horizon, most=MOST_SCORED, skip=skip)


def _segments(episodes: Sequence[Episode], where: list[tuple[int, int]], steps: int) -> Segments:
    step, measurement = episodes[0].step, episodes[0].measurement
    space, rows = measurement.coordinates, []
    for index, first in where:
        e = episodes[index]
        begin = first * step
        inside = np.flatnonzero((e.time > begin + 1e-9) & (e.time <= begin + steps * step + 1e-9))
        # In a leapfrog the velocity belongs half a step before the position.
        when = [begin] * space.positions + [begin - 0.5 * step] * space.dofs
        start = [np.interp(t, e.time, column) for t, column in zip(when, e.state.T, strict=True)]
        rows.append((inside, (e.time[inside] - begin) / step, e, start))
    # A gap in the log leaves rollouts with few readings or none: they tell nothing.
    counts = np.array([e.valid[inside].sum(axis=0) for inside, _, e, _ in rows])
    enough = np.maximum(2.0, 0.5 * np.median(counts, axis=0))
    read = counts.any(axis=0)
    kept = np.flatnonzero(np.all((counts >= enough)[:, read], axis=1)).tolist()
    if not kept:
        raise DiagnosisError(
            f"no stretch of {steps * step:g} s holds enough readings",
            where=", ".join(e.name for e in episodes),
            fix="record at 10 readings a second or more, without gaps",
        )
    where, rows = [where[i] for i in kept], [rows[i] for i in kept]
    most = max(len(inside) for inside, _, _, _ in rows)
    offset, reading = np.zeros((len(rows), most)), np.zeros((len(rows), most, space.dofs))
    valid = np.zeros(reading.shape, dtype=bool)
    attitude = np.zeros((len(rows), most, len(space.balls), 4))
    attitude[..., 0] = 1.0
    for row, (inside, where_in, e, _) in enumerate(rows):
        valid[row, : len(inside)] = e.valid[inside]
        offset[row, : len(inside)] = where_in
        reading[row, : len(inside)] = e.reading[inside]
        attitude[row, : len(inside)] = e.attitude[inside]
    before = np.clip(offset.astype(np.int64), 0, steps - 1)
    noise = np.sqrt(np.mean([e.noise**2 for e in episodes], axis=0))
    guess = np.max([e.guess for e in episodes], axis=0)
    return Segments(
        measurement=measurement,
        episodes=tuple(episodes),
        episode=np.array([index for index, _ in where]),
        first=np.array([first for _, first in where]),
        steps=steps,
        before=before,
        part=offset - before,
        valid=valid,
        reading=reading,
        attitude=attitude,
        start=_normal(np.array([start for _, _, _, start in rows]), space),
        start_trust=_start_trust(episodes, noise, guess),
        noise=noise,
        guess=guess,
    )


def _normal(start: Array, space: Coordinates) -> Array:
    """Return starts of which quaternions were interpolated, with these of length 1."""
    for at, _ in space.balls:
        start[:, at : at + 4] = unit(start[:, at : at + 4])
    return start


def smoothed_noise(episode: Episode, noise: Array) -> Array:
    """Return the standard deviation of a light smoothing's positions, shape (channels,).

    Args:
        episode: Whose readings are smoothed.
        noise: Of each channel's readings, white.
    """
    clocks = [episode.time[there] if there.any() else episode.time for there in episode.valid.T]
    period = np.array([np.median(np.diff(clock)) for clock in clocks])
    return np.asarray(noise * np.sqrt(2.0 * episode.state_cutoff * period))


def _start_trust(episodes: Sequence[Episode], noise: Array, guess: Array) -> Array:
    """Return how far smoothed starts may be trusted: noise let through, and motion cut off.

    Of joints that were not read they are guesses.
    """
    cutoff, passed = episodes[0].state_cutoff, smoothed_noise(episodes[0], noise)
    rates = [e.state[:, e.measurement.coordinates.positions :] for e in episodes]
    speed = np.sqrt(np.mean(np.concatenate([rate**2 for rate in rates]), axis=0))
    of_position = np.maximum(noise, passed)
    of_velocity = 2.0 * np.pi * cutoff * passed + 0.02 * speed + 1e-6
    unknown = np.concatenate([guess, np.where(guess > 0.0, speed + guess * QUICK, 0.0)])
    spread: Array = np.concatenate([of_position, of_velocity]) + unknown
    return 1.0 / spread**2
