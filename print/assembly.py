"""In which order a body is put together, in words: first each link, then link to link."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from morph.print.explode import Explosion
from morph.print.part import Hinge, Part

Key = TypeVar("Key")
Found = TypeVar("Found")

MOST_NAMED = 6
"""Links or joints that a step names; of more it says how many."""

CENTRED = (
    "Set each servo to its middle before its horn goes on, as drawn, and turn each joint by hand."
)
"""What is to be known before links are put onto each other."""


@dataclass(frozen=True, kw_only=True)
class AssemblyStep:
    """Something to do, once or for several links that are alike."""

    title: str
    """What to do."""
    links: tuple[str, ...]
    """The links that come to be, or that are put onto others; each once."""
    needs: tuple[tuple[int, str, str], ...] = ()
    """What it takes each time: how many, part number, name."""
    said: tuple[str, ...] = ()
    """How, a sentence each."""


def steps(
    parts: Sequence[Part], hinges: Sequence[Hinge], explosion: Explosion
) -> tuple[AssemblyStep, ...]:
    """Return how to put a body together.

    Args:
        parts: All that it is made of; what is fused comes with the part that it is fused into.
        hinges: How its links move.
        explosion: The body taken apart, which knows the order of its links.
    """
    within = {link: _contents(link, parts) for link in explosion.links}
    makes = _alike((within[link], link) for link in explosion.links if _work(within[link]))
    joined = _alike(
        ((hinge.kind, within[hinge.still], within[hinge.moving]), hinge)
        for link in explosion.links
        for hinge in hinges
        if hinge.moving == link and hinge.still in within
    )
    return (
        *(_make(contents, links) for contents, links in makes),
        *(
            _join(result, explosion.parent, first=not at)
            for at, result in enumerate(_chained(joined))
        ),
    )


def short(names: Sequence[str]) -> str:
    """Return names in a row; of many the first and how many more."""
    shown = ", ".join(name.replace("_", " ") for name in names[:MOST_NAMED])
    more = len(names) - MOST_NAMED
    return f"{shown} and {more} more" if more > 0 else shown


Contents = tuple[tuple[int, Part], ...]


def _contents(link: str, parts: Iterable[Part]) -> Contents:
    results = []
    for part in parts:
        count = sum(placement.link == link for placement in part.placements)
        if count and part.kind != "fused":
            results.append((count, part))
    return tuple(results)


def _work(contents: Contents) -> bool:
    """Return whether a link is more than one part with nothing in it."""
    return sum(count for count, _ in contents) > 1 or any(part.seats for _, part in contents)


def _alike(pairs: Iterable[tuple[Key, Found]]) -> list[tuple[Key, list[Found]]]:
    """Return what has the same key together, in the order of the first of each."""
    results: dict[Key, list[Found]] = {}
    for key, it in pairs:
        results.setdefault(key, []).append(it)
    return list(results.items())


def _make(contents: Contents, links: Sequence[str]) -> AssemblyStep:
    printed = [(count, part) for count, part in contents if part.kind == "printed"]
    bought = [(count, part) for count, part in contents if part.kind == "bought"]
    lines = []
    if any(part.piece_of for _, part in printed):
        lines.append(
            "Put the pieces together with their pins: they go together one way only. "
            "A drop of glue on each face holds them."
        )
    elif sum(count for count, _ in printed) > 1:
        lines.append("Join the printed parts, which do not move against each other.")
    for _, part in printed:
        if part.seats:
            lines.append(f"{_called(part)} holds {_held(part)}.")
    loose = [
        f"{count} {part.name.replace('_', ' ')}" if count > 1 else part.name.replace("_", " ")
        for count, part in bought
        if not any(_same(seat.holds, part.name) for _, each in printed for seat in each.seats)
    ]
    if loose:
        lines.append(f"In it go, where there is room for them: {', '.join(loose)}.")
    return AssemblyStep(
        title=f"Make {short(links)}",
        links=tuple(links),
        needs=tuple((count, part.number, part.name) for count, part in contents),
        said=tuple(lines),
    )


def _chained(joined: Iterable[tuple[object, list[Hinge]]]) -> list[list[Hinge]]:
    """Return joints by steps: those that are like no other go into the step before them."""
    results: list[list[Hinge]] = []
    single = False
    for _, hinges in joined:
        if single and len(hinges) == 1 and len(results[-1]) < MOST_NAMED:
            results[-1] += hinges
        else:
            results.append(list(hinges))
        single = len(hinges) == 1
    return results


def _join(results: Sequence[Hinge], parent: Mapping[str, str], *, first: bool) -> AssemblyStep:
    notes = [CENTRED] if first else []
    for hinge in results[:MOST_NAMED]:
        way = "turns about" if hinge.kind == "hinge" else "slides along"
        closing = " This closes a chain." if parent.get(hinge.moving) != hinge.still else ""
        notes.append(
            f"The {short([hinge.moving])} goes onto the {short([hinge.still])}: it {way} the axis "
            f"of the joint {short([hinge.name])}.{closing}"
        )
    return AssemblyStep(
        title=f"Put on {short([hinge.moving for hinge in results])}",
        links=tuple(hinge.moving for hinge in results),
        said=tuple(notes),
    )


def _called(part: Part) -> str:
    name = part.name.replace("_", " ")
    return f"{part.number} ({name})" if part.number else name


def _held(part: Part) -> str:
    counts = Counter(seat.holds for seat in part.seats)
    return ", ".join(f"{count} × {what}" if count > 1 else what for what, count in counts.items())


def _same(holds: str, name: str) -> bool:
    """Return whether a seat is for a bought part, whose name is lower case with underscores."""
    plain = "".join(each for each in holds.lower() if each.isalnum())
    return plain in "".join(each for each in name.lower() if each.isalnum())
