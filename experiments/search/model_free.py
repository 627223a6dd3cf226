"""Stable-Baselines3's SAC on the same swing-up, where it is installed.

What learning costs without a model: it gets the environment of `morph.task.gym`, and many more
trials than anybody would make.
"""

from __future__ import annotations

import time
from importlib.util import find_spec

import numpy as np

from morph.body.load import load
from morph.policy.observing import observations_of
from morph.search.evaluate import Score
from morph.task.run import run
from morph.task.tasks import task


def installed() -> bool:
    """Return whether stable-baselines3 is there."""
    return find_spec("stable_baselines3") is not None


def baseline(seed: int, *, trials: int) -> dict[str, float]:
    """Return how SAC does on the cart-pole after so many trials of 60 control steps."""
    import torch
    from stable_baselines3 import SAC

    from morph.task.gym import environment

    torch.set_num_threads(2)
    wanted = task("swing-up", load("cartpole"))
    began = time.perf_counter()
    # A gradient step for each control step, the library's own settings but for a shorter warm-up.
    learner = SAC("MlpPolicy", environment(wanted), seed=seed, learning_starts=300)
    learner.learn(total_timesteps=60 * trials)
    seconds = time.perf_counter() - began
    simulator = wanted.simulator()
    rng = np.random.default_rng(seed + 7_000_001)
    q, v = wanted.start.sample(wanted.robot, simulator.model, 100, rng)
    size = len(observations_of(wanted.robot))
    low, high = learner.action_space.low, learner.action_space.high

    def act(q: np.ndarray, v: np.ndarray, now: float) -> np.ndarray:
        seen = np.concatenate([q, v], axis=1)
        seen = seen + rng.normal(scale=wanted.noise, size=(len(q), size))
        told, _ = learner.predict(seen.astype(learner.observation_space.dtype), deterministic=True)
        return np.asarray(np.clip(told, low, high) * (10.0 / high), dtype=float)

    moved = run(wanted, simulator, act, q, v)
    score = Score(loss=wanted.loss(moved), success=wanted.succeeded(moved))
    return {"seconds": seconds, "trials": trials, "loss": score.mean, "share": score.share}
