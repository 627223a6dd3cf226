"""Bodies of a design on the stage: the design, and the description as a ghost."""

from __future__ import annotations

import numpy as np

from morph.app.viewer.content import Actor, Colour
from morph.app.viewer.design.design_state import Bench
from morph.app.viewer.motion import MotionFrames, posed
from morph.body.posture import Posture

GHOST: Colour = (120, 130, 145)
"""Colour of the body as described."""

SHAPING = ("scale", "lock")
"""Operations that change what a body looks like: without them, the two would be one."""


class Shown:
    """What is shown of a design as it is built now.

    Its motions are of this person alone, and are written to in place: a slider moves links, and
    nothing is sent anew.

    Args:
        bench: The design.
        ghost: Whether the body as described is shown too, where it differs.
    """

    def __init__(self, bench: Bench, ghost: bool) -> None:
        """Take the bodies in their poses."""
        by = {parameter.name: parameter.operation for parameter in bench.plan.parameters}
        self._bench = bench
        self._ghost = ghost and any(by[name] in SHAPING for name in bench.built.values)
        self._motion = self._design()
        self._original = Posture(bench.plan.original.figure.model) if self._ghost else None
        self._shadow = self._described()

    @property
    def actors(self) -> tuple[Actor, ...]:
        """The design first."""
        design = Actor(figure=self._bench.built.figure, motion=self._motion, lane=0)
        if self._shadow is None:
            return (design,)
        ghost = Actor(
            figure=self._bench.plan.original.figure,
            motion=self._shadow,
            lane=0,
            ghost=True,
            colour=GHOST,
            title="",
        )
        return design, ghost

    def pose(self) -> None:
        """Bring both into the pose that the joints have now."""
        _write(self._motion, self._design())
        shadow = self._described()
        if self._shadow is not None and shadow is not None:
            _write(self._shadow, shadow)

    def _design(self) -> MotionFrames:
        return posed(self._bench.posture.model, self._bench.pose[None])

    def _described(self) -> MotionFrames | None:
        posture, pose = self._original, self._bench.choice.pose
        if posture is None:
            return None
        goal = np.array([pose.get(handle.joint, handle.rest) for handle in posture.handles])
        return posed(posture.model, posture.towards(posture.rest, goal)[0][None])


def _write(motion: MotionFrames, result: MotionFrames) -> None:
    motion.position[:], motion.turn[:] = result.position, result.turn
