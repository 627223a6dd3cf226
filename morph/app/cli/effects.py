"""Effects as they are named at the command line: `NAME@WHERE:param=value,param=value`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from morph.body.robot import Robot
from morph.errors import EffectError
from morph.nearest import nearest
from morph.physics import effect_class
from morph.physics.effect import Effect, Parameter

MOST_PARAMETERS = 4
"""Parameters that are all told of an effect; of one with more only those that say something."""

MOST_SHOWN = 12
"""Places that an error lists before it counts the rest."""


def asked_effects(
    robot: Robot, texts: Sequence[str], *, file: Path | None = None, world: Sequence[Effect] = ()
) -> tuple[Effect, ...]:
    """Return all effects that the command line asks for; a nearer word replaces a farther one.

    A world comes first, then the file, then single effects. One of the file that acts at the
    same place as the world's takes its place; a single one changes the parameters that it tells.

    Args:
        robot: What they act on.
        texts: Each `NAME@WHERE:param=value,param=value`.
        file: A `corrected.toml`, or another file like it.
        world: What the world around it does.

    Raises:
        EffectError: An effect, its place or a parameter is not known, a value is out of
            bounds, the file cannot be used, or one effect is asked for twice.
    """
    results = {effect.label: effect for effect in world}
    if file is not None:
        from morph.physics.store import load_effects

        loaded = load_effects(file)
        for effect in loaded:
            _check_place(effect, robot, where=f"{file}, {effect.label}")
        _check_once(loaded, str(file))
        results |= {effect.label: effect for effect in loaded}
    single = [parsed(text, robot, results) for text in texts]
    _check_once(single, "--effect")
    return tuple({**results, **{effect.label: effect for effect in single}}.values())


def _check_once(effects: Sequence[Effect], where: str) -> None:
    """Refuse two of one name at one place; a contact has two names, one from each side."""
    seen = set()
    for effect in effects:
        one = (effect.name, frozenset(effect.where.split("+")))
        if one in seen:
            raise EffectError(
                f"{effect.label} is asked for twice",
                where=where,
                fix="ask for it once, with all its parameters",
            )
        seen.add(one)


def parsed(
    text: str,
    robot: Robot,
    among: Mapping[str, Effect] | None = None,
    *,
    option: str = "--effect",
) -> Effect:
    """Return the effect that `NAME@WHERE:param=value,param=value` asks for.

    For an effect on the world `@world` may be left out. Of an effect that is already `among`
    others, by its label, only the parameters that are told change. `option` is named in errors.

    Raises:
        EffectError: The effect, its place or a parameter is not known, or a value is out of
            bounds.
    """
    where = f"{option} {text}"
    name, place, values = _taken_apart(text)
    kind = effect_class(name, where=where)
    if not place and kind.kind == "world":
        place = "world"
    if not place:
        raise EffectError(
            f"{name} acts on {_a(kind.kind)}, and none is named",
            where=where,
            fix=f"write {name}@{(*kind.places(robot), 'NAME')[0]}:...",
        )
    effect = kind.at(place)
    effect = (among or {}).get(effect.label, effect)
    _check_place(effect, robot, where=where)
    given = {}
    for pair in values.split(",") if values else ():
        known, value = _value(pair, kind, where)
        if known in given:
            raise EffectError(f"{known} is given twice", where=where, fix=f"give {known} once")
        given[known] = value
    return replace(effect, **given)  # type: ignore[type-var]


def shown(effect: Effect) -> str:
    """Return an effect in words: `viscous_friction@hinge (b = 0.1 N m s/rad)`.

    Of one with many parameters those are left out that say nothing.
    """
    values = {known: getattr(effect, known.name) for known in effect.parameters()}
    if len(values) > MOST_PARAMETERS:
        values = {
            known: value
            for known, value in values.items()
            if value != (known.default if known.neutral is None else known.neutral)
        }
    lines = [f"{known.name} = {value:g}{_unit(known)}" for known, value in values.items()]
    return effect.label + (f" ({', '.join(lines)})" if lines else "")


def _taken_apart(text: str) -> tuple[str, str, str]:
    """Return the name, the place and the parameters; names of places may hold a colon."""
    head, colon, values = text.rpartition(":")
    if not colon or "=" not in values:
        head, values = text, ""
    name, _, place = head.partition("@")
    return name.strip(), place.strip().removesuffix(":"), values.strip()


def _check_place(effect: Effect, robot: Robot, *, where: str) -> None:
    places = effect.places(robot)
    if effect.where in places:
        return
    raise EffectError(
        f"{robot.name} has no {effect.kind} {effect.where!r} for {effect.name}; "
        f"there are {_some(places)}",
        where=where,
        fix=f"the nearest are {nearest(effect.where, places)}"
        if places
        else f"leave {effect.name} out: it has nothing to act on here",
    )


def _value(pair: str, kind: type[Effect], where: str) -> tuple[str, float]:
    name, equals, value = (part.strip() for part in pair.partition("="))
    known = {each.name: each for each in kind.parameters()}
    if name not in known:
        raise EffectError(
            f"{kind.name} has no parameter {name!r}; it has {_parameters(known.values())}",
            where=where,
            fix=f"write {kind.name}@WHERE:{next(iter(known), 'NAME')}=VALUE"
            if known
            else "write it without parameters",
        )
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not equals or not math.isfinite(number):
        raise EffectError(
            f"{name} = {value!r} is no finite number",
            where=where,
            fix=f"give {name} from {known[name].low:g} to {known[name].high:g}{_unit(known[name])}",
        )
    return name, number


def _parameters(known: Iterable[Parameter]) -> str:
    return ", ".join(f"{each.name}{_unit(each)}" for each in known) or "none"


def _unit(known: Parameter) -> str:
    return "" if known.unit == "-" else f" {known.unit}"


def _some(names: Sequence[str]) -> str:
    more = len(names) - MOST_SHOWN
    return (", ".join(names[:MOST_SHOWN]) or "none") + (f" and {more} more" if more > 0 else "")


def _a(kind: str) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
