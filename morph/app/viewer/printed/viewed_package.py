"""A print package as shown: parts, colours and exploded view."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from morph.app.viewer.content import Actor, Colour, Moment
from morph.app.viewer.printed import figures
from morph.app.viewer.printed.choices import APART, PLATES, STEPS, PrintChoices
from morph.app.viewer.printed.skin import HOT, PAINTERS, PLAIN, Skin, mixed, skins
from morph.arrays import Array
from morph.body.robot import Robot
from morph.fabrication.content import Package
from morph.print.explode import Explosion, exploded
from morph.print.job import Plate

PARTS: tuple[Colour, ...] = (
    (116, 169, 207),
    (230, 171, 85),
    (102, 176, 140),
    (204, 132, 168),
    (160, 150, 208),
    (196, 186, 92),
)
"""Of printed parts, in turn."""

BOUGHT: Colour = (112, 118, 126)
"""Of what is bought."""

UNTOLD: Colour = (150, 156, 164)
"""Of parts of which a colouring tells nothing."""

HELD: Colour = (255, 196, 0)
"""Of the part that is pointed at."""


class ViewedPackage:
    """What is seen of one package; shared by all who look.

    Args:
        robot: The body.
        package: What is printed of it.
    """

    def __init__(self, robot: Robot, package: Package) -> None:
        """Prepare what every showing needs; colours that take long wait for `paint`."""
        self.robot, self.package, self.job = robot, package, package.job
        self._painted: dict[str, dict[str, Array]] = {}
        self.skins: dict[str, Skin] = skins((*self.job.parts, *self.job.refused, *self.job.gauges))
        self.told: Explosion = exploded((*self.job.parts, *self.job.refused), package.hinges)
        """The body taken apart; what was refused is part of it."""

    @property
    def ways(self) -> tuple[str, ...]:
        """What can be shown."""
        names = tuple(plate.name for plate in self.job.plates)
        return (APART, STEPS, *((PLATES,) if len(names) > 1 else ()), *names)

    def has(self, by: str) -> bool:
        """Return whether a colouring can be shown at once."""
        return by not in PAINTERS or by in self._painted

    def paint(self, by: str) -> None:
        """Make a colouring; it may take seconds."""
        if self.has(by):
            return
        results = {name: PAINTERS[by](skin, self.job) for name, skin in self.skins.items()}
        self._painted[by] = {name: it for name, it in results.items() if it is not None}

    def actors(self, chosen: PrintChoices) -> tuple[tuple[Actor, ...], tuple[Moment, ...]]:
        """Return what is on the stage, and the moments to jump to."""
        colours = self._colours(chosen)
        plates = [plate for plate in self.job.plates if chosen.show in (PLATES, plate.name)]
        if plates:
            return tuple(self._on_bed(plate, colours) for plate in plates), ()
        show = figures.together if chosen.show == STEPS else figures.apart
        gauges = {part.name for part in self.job.gauges}
        body = {name: skin for name, skin in self.skins.items() if name not in gauges}
        actor, moments = show(self.robot, body, self.told, colours, self.package.title)
        return (actor,), moments

    def grams(self, name: str) -> float | None:
        """Return what one copy of a part weighs, g; None if it is not known."""
        if name in self.package.readings:
            return 1e3 * self.package.readings[name]
        sliced, part = self.job.sliced.get(name), self.skins[name].part
        weight = part.weight if sliced is None else sliced.weight
        return None if weight is None else 1e3 * weight.mass

    @cached_property
    def heaviest(self) -> float:
        """The greatest mass of one copy, g."""
        return max((self.grams(name) or 0.0 for name in self.skins), default=0.0)

    def _on_bed(self, plate: Plate, colours: figures.Colours) -> Actor:
        bed, title = self.job.profile.printer.bed_mm, plate.name.replace("_", " ")
        return figures.on_bed(self.robot, plate, bed, self.skins, colours, title)

    def _colours(self, chosen: PrintChoices) -> figures.Colours:
        """Return the colour of each part, or of its corners."""
        painted = self._painted.get(chosen.by)
        printed = [name for name, skin in self.skins.items() if skin.part.kind != "bought"]
        results: dict[str, Array | Colour] = {}
        for name, skin in self.skins.items():
            if name == chosen.part:
                results[name] = HELD
            elif painted is not None:
                results[name] = painted.get(name, UNTOLD)
            elif chosen.by == "mass":
                results[name] = self._by_mass(name)
            elif skin.part.kind == "bought":
                results[name] = BOUGHT
            else:
                results[name] = PARTS[printed.index(name) % len(PARTS)]
        return results

    def _by_mass(self, name: str) -> Colour:
        grams = self.grams(name)
        if grams is None:
            return UNTOLD
        share = np.array([grams / (self.heaviest or 1.0)])
        red, green, blue = np.rint(mixed(PLAIN, HOT, share)[0]).astype(int).tolist()
        return red, green, blue
