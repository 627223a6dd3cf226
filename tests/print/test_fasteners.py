from __future__ import annotations

import numpy as np

from morph.print.fasteners import fasteners
from morph.print.part import Part, Placement, Seat


def seat(holds: str, bore_mm: float, x: float, z: float = 0.0) -> Seat:
    axis = np.array([0.0, 0.0, 1.0])
    return Seat(holds=holds, position=np.array([x, 0.0, z]), axis=axis, bore_mm=bore_mm)


def part(name: str, *seats: Seat, z: tuple[float, ...] = (0.0,)) -> Part:
    places = []
    for at, height in enumerate(z):
        world = np.eye(4)
        world[2, 3] = height
        places.append(Placement(link=f"{name}_{at}", pose=np.eye(4), world=world))
    return Part(name=name, kind="printed", mesh=None, placements=tuple(places), seats=seats)


def counts(*parts: Part) -> dict[str, int]:
    return {each.name: each.count for each in fasteners(parts)}


def test_a_screw_through_one_part_into_another_is_one_screw() -> None:
    # M3 passes 3.4 mm and cuts into 2.6 mm; the parts lie 5 mm apart.
    through, into = (
        part("through", seat("M3", 3.4, 0.0)),
        part("into", seat("M3", 2.6, 0.0), z=(5,)),
    )
    assert counts(through, into) == {"M3": 1}
    aside = part("aside", seat("M3", 2.6, 1.0), z=(5.0,))
    assert counts(through, aside) == {"M3": 2}


def test_a_screw_into_a_servo_is_counted_from_the_hole_that_it_passes() -> None:
    holder = part("holder", *(seat("M2", 2.4, x) for x in (0.0, 10.0, 20.0, 30.0)))
    assert counts(holder) == {"M2": 4}


def test_a_horn_takes_as_many_screws_as_it_has_holes() -> None:
    # The horn of an STS3215 has a circle of four M3, as the catalogue says.
    assert counts(part("arm", seat("STS3215 horn", 7.0, 0.0))) == {"M3": 4}


def test_every_copy_and_every_bearing_counts() -> None:
    leg = part("leg", seat("608", 22.2, 0.0), seat("M8", 7.0, 0.0), z=(0.0, 100.0, 200.0))
    assert counts(leg) == {"M8": 3, "608": 3}
    (screws, bearings) = fasteners([leg])
    assert (screws.kind, bearings.kind) == ("screw", "bearing")
    assert bearings.links == ("leg_0", "leg_1", "leg_2")


def test_a_servo_itself_is_no_fastener() -> None:
    assert counts(part("holder", seat("STS3215", 0.0, 0.0))) == {}
