"""Many cases of one robot, simulated together."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.conceal.case import Case
from experiments.conceal.draw import Sizes, first, parameters, suited
from experiments.conceal.equations import Array, Equations, Parameters
from experiments.conceal.excite import KINDS, SECONDS, Episode, plan, scaled
from experiments.conceal.laws import Laws, neutral
from experiments.conceal.march import KEEP, STEP, Drive, Motion, march
from experiments.conceal.mechanisms import MECHANISMS
from experiments.conceal.sensor import noise_rms, quanta
from experiments.conceal.strength import strength

EPISODES = len(KINDS)


@dataclass(frozen=True, kw_only=True)
class Batch:
    """Cases of one robot; case i owns the rows 5 i to 5 i + 4."""

    cases: tuple[Case, ...]
    """What is hidden in each."""
    true: Parameters
    """True masses, distances and inertias, each of shape (cases,)."""
    gains: Array
    """True gains, which every description has slightly wrong, shape (joints, cases)."""
    rates: tuple[float, ...]
    """How often each logger ticks, Hz."""
    episodes: tuple[Episode, ...]
    """One for each row."""
    rngs: tuple[np.random.Generator, ...]
    """Each case's own chance, so that a case is the same in any company."""

    @property
    def equations(self) -> Equations:
        """The mechanism."""
        return MECHANISMS[self.cases[0].robot]

    @property
    def drive(self) -> Drive:
        """The commands of all rows."""
        return Drive(
            ticks=tuple(e.ticks for e in self.episodes),
            commands=tuple(e.commands for e in self.episodes),
        )

    @property
    def rows(self) -> Parameters:
        """True parameters for each row."""
        return {name: np.repeat(value, EPISODES) for name, value in self.true.items()}

    def plain(self) -> Laws:
        """Return the laws of all rows without any effect."""
        laws = neutral(len(self.equations.joints), len(self.episodes))
        laws.gain[:] = np.repeat(self.gains, EPISODES, axis=1)
        return laws

    def laws(self, sizes: list[Sizes]) -> Laws:
        """Return the laws of all rows with their effects."""
        laws = self.plain()
        for number, (case, size) in enumerate(zip(self.cases, sizes, strict=True)):
            if case.effect is not None:
                rows = slice(EPISODES * number, EPISODES * (number + 1))
                laws = laws.put(case.effect, case.joint, rows, parameters(case, size))
        return laws

    def run(self, sizes: list[Sizes], *, step: float = STEP) -> tuple[Motion, Array]:
        """Return the true motion of all rows, and each case's strength."""
        equations, laws, drive = self.equations, self.laws(sizes), self.drive
        start = np.array([e.start for e in self.episodes]).T
        torque = drive.produced(laws, np.zeros(len(self.episodes)), round(SECONDS / step), step)
        motion = march(
            equations, self.rows, laws, torque, start, np.zeros_like(start), step=step, keep=KEEP
        )
        noise = np.array([noise_rms(quanta(equations, s.counts)) for s in sizes])
        square = strength(
            equations, self.rows, self.plain(), drive, motion, laws.offset,
            np.repeat(noise.T, EPISODES, axis=1), step=step,
        )  # fmt: skip
        return motion, np.sqrt(square.reshape(-1, EPISODES).mean(axis=1))

    def turned_down(self, motion: Motion) -> Batch:
        """Return the batch with weaker commands in the rows that moved too far.

        An experimenter who sees the real robot leave its range turns the
        amplitude down, whatever the description had promised.
        """
        span = np.array([reach.span for reach in self.equations.reach])[:, None]
        far = (np.abs(motion.q).max(axis=0) > 1.3 * span).any(axis=0)
        if not far.any():
            return self
        episodes = tuple(
            replace(e, commands=(0.75 * e.commands).round(6)) if much else e
            for e, much in zip(self.episodes, far, strict=True)
        )
        return replace(self, episodes=episodes)

    def settled(self, *, rounds: int = 10) -> tuple[Batch, list[Sizes]]:
        """Return amplitudes that suit the true robots, and sizes with the strengths wanted.

        Found on a step of 1 ms. The last rounds leave the amplitudes alone.
        """
        batch = self
        sizes = [first(case, rng) for case, rng in zip(self.cases, self.rngs, strict=True)]
        for number in range(rounds):
            before = batch, sizes
            motion, found = batch.run(sizes, step=10 * STEP)
            sizes = [
                suited(*each)
                for each in zip(self.cases, sizes, found.tolist(), self.rngs, strict=True)
            ]
            if number < rounds - 4:
                batch = batch.turned_down(motion)
            if batch is before[0] and sizes == before[1]:
                # Every later round would run the same again.
                break
        return batch, sizes


def prepare(cases: list[Case]) -> Batch:
    """Return cases of one robot with their truths drawn and their commands planned."""
    equations = MECHANISMS[cases[0].robot]
    rngs = [np.random.default_rng(case.seed) for case in cases]
    true = {name: np.full(len(cases), value) for name, value in equations.nominal().items()}
    gains = np.ones((len(equations.joints), len(cases)))
    rates, episodes = [], []
    for number, rng in enumerate(rngs):
        for name in equations.varied:
            true[name][number] *= rng.uniform(0.9, 1.1)
        gains[:, number] = rng.uniform(0.95, 1.05, len(equations.joints))
        rates.append(float(np.round(rng.uniform(200.0, 500.0))))
        episodes += plan(equations, rng, rates[-1])
    return Batch(
        cases=tuple(cases),
        true=true,
        gains=gains,
        rates=tuple(rates),
        episodes=tuple(scaled(equations, episodes)),
        rngs=tuple(rngs),
    )
