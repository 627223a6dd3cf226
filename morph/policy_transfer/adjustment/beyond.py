"""How much of what a target does no adjustment mends: no command makes the source do it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.alignment.states import change
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.target import Experience
from morph.search.trajectory.linearise import linearise


def beyond(source: SimulatedTask, runs: Sequence[Experience]) -> float:
    """Return how far a target's steps are from what the source could do, in what noise does.

    A command moves a state along B alone. What remains of a step beside B, after the command of
    the source that explains it best, is chance r with covariance

        S = noise^2 P (1 + A A') P',  P a basis of all that is orthogonal to B,

    if source and target differ in forces of the actuators alone, as by friction of a driven
    joint. Given back is sqrt(mean of r' S^-1 r / dimensions): about 1 then, and more if the body
    itself is another, such as a longer pole.

    Args:
        source: The source.
        runs: What the target did.
    """
    seen = source.transitions(runs)
    plant = source.plant
    u = source.inverse(seen.state, seen.after)
    reached = source.after(seen.state, np.clip(u, plant.low, plant.high))
    left = change(reached, seen.after, source.turns)
    nq = plant.model.nq
    A, B = linearise(plant, seen.state[:, :nq], seen.state[:, nq:], 0.0 * u)
    # The last columns of a full orthogonal basis that begins with B's own directions.
    whole = np.linalg.svd(B, full_matrices=True)[0]
    P = np.swapaxes(whole[..., B.shape[-1] :], 1, 2)
    S = P @ (np.eye(len(A[0])) + A @ np.swapaxes(A, 1, 2)) @ np.swapaxes(P, 1, 2)
    r = (P @ left[..., None])[..., 0]
    noise = max(source.task.noise, 1e-6)
    each = np.einsum("mi,mi->m", r, np.linalg.solve(S, r[..., None])[..., 0]) / noise**2
    fine = np.isfinite(each)
    return float(np.sqrt(np.mean(each[fine]) / r.shape[1]))
