"""A design's state, read again from JSON that anybody may have written."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from morph.app.viewer.design.design_state import BodyPlan, DesignChoice
from morph.arrays import JSON
from morph.errors import ViewError

KEYS = ("body", "show_original", "designs")
"""Keys of a state."""


def restored(plans: Sequence[BodyPlan], state: JSON) -> tuple[int, bool, dict[int, DesignChoice]]:
    """Return the chosen body, whether its original is shown, and each body's choice.

    Args:
        plans: The bodies that are shown.
        state: What `Design.state` returned; what it leaves out is as at first.

    Raises:
        ViewError: A key, a body, a parameter or a joint is unknown, or a value is not one.
    """
    table = _table(state, "design")
    _known(table, KEYS, "design")
    body, shown = table.get("body", 0), table.get("show_original", True)
    if isinstance(body, bool) or not isinstance(body, int) or not 0 <= body < len(plans):
        raise _unfit(f"the body {body!r} is not one of the {len(plans)} that are shown", "body")
    if not isinstance(shown, bool):
        raise _unfit(f"show_original is {shown!r}, neither true nor false", "show_original")
    choices = {}
    for number, design in _table(table.get("designs", {}), "designs").items():
        if number not in {str(at) for at in range(len(plans))}:
            raise _unfit(f"it designs body {number[:20]!r} of {len(plans)}", "designs")
        choices[int(number)] = _choice(plans[int(number)], design, f"designs.{number}")
    return body, shown, choices


def _choice(plan: BodyPlan, state: object, where: str) -> DesignChoice:
    table = _table(state, where)
    _known(table, ("parameters", "pose"), where)
    values, pose = (_table(table.get(key, {}), f"{where}.{key}") for key in ("parameters", "pose"))
    ranges = {each.name: (each.low, each.high) for each in plan.parameters}
    _known(values, ranges, f"{where}.parameters")
    _known(pose, [joint.name for joint in plan.robot.joints], f"{where}.pose")
    for name, value in values.items():
        low, high = ranges[name]
        if not low <= _number(value, f"{where}.parameters.{name}") <= high:
            raise _unfit(f"{name} is {value}, outside {low:g} to {high:g}", f"{where}.parameters")
    return DesignChoice(
        values={name: _number(value, name) for name, value in values.items()},
        pose={name: _number(value, f"{where}.pose.{name}") for name, value in pose.items()},
    )


def _table(result: object, where: str) -> dict[str, object]:
    if not isinstance(result, dict):
        raise _unfit(f"it holds {type(result).__name__} instead of a table", where)
    return result


def _known(table: dict[str, object], known: Iterable[str], where: str) -> None:
    for name in table:
        if name not in set(known):
            raise _unfit(f"there is no {str(name)[:60]!r}", where)


def _number(result: object, where: str) -> float:
    if isinstance(result, bool) or not isinstance(result, int | float) or not math.isfinite(result):
        raise _unfit(f"{str(result)[:60]!r} is no number", where)
    return float(result)


def _unfit(what: str, where: str) -> ViewError:
    return ViewError(
        what, where=f"state of the view design, {where}", fix="save the view anew from the page"
    )
