"""What the effects of what links weigh have in common: where a diagnosis looks for them."""

from __future__ import annotations

from morph.body.robot import Robot
from morph.physics.kinds import BodyEffect


class WeighedEffect(BodyEffect):
    """An effect of what a link weighs, and where."""

    @classmethod
    def suspects(cls, robot: Robot) -> tuple[str, ...]:
        """Return the links that move and that the card says are printed.

        What comes off a printer seldom weighs what was drawn. A link that was machined or
        weighed is better than the ten percent that its figures are refitted within, and an
        offset of its centre would take the blame for the zero of its sensor.
        """
        if robot.card is None or robot.card.print is None:
            return ()
        moved = {joint.link for joint in robot.joints}
        for link in robot.links:
            # Links are listed after what carries them.
            moved |= {link.name} if link.parent in moved else set()
        printed = robot.card.print.printed
        return tuple(name for name in cls.places(robot) if name in printed and name in moved)
