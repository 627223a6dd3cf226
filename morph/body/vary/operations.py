"""Every operation, and how a table of a card or a chain names one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from morph.body.table import Place, read_table
from morph.body.vary.add import Add
from morph.body.vary.drop import Drop
from morph.body.vary.heavier import Heavier
from morph.body.vary.lock import Lock
from morph.body.vary.operation import Operation
from morph.body.vary.part import unknown
from morph.body.vary.scale import Scale
from morph.body.vary.stiffen import Stiffen

OPERATIONS: tuple[type[Operation], ...] = (Scale, Add, Drop, Lock, Stiffen, Heavier)
"""Every operation."""


def kind_of(name: str, where: str) -> type[Operation]:
    """Return the class of the operation of a name.

    Raises:
        RobotError: There is no such operation.
    """
    for kind in OPERATIONS:
        if kind.name == name:
            return kind
    raise unknown("operation", name, (kind.name for kind in OPERATIONS), where)


def operation_of(table: Mapping[str, Any], place: Place | None = None) -> Operation:
    """Return the operation that a TOML table names, with its settings.

    Args:
        table: The key `operation` names it; the other keys are its fields.
        place: Where the table stands, for an error.

    Raises:
        RobotError: There is no such operation, or a key is unknown, missing or
            holds a value that it cannot.
    """
    place = place or Place(file="operation", text="")
    kind = kind_of(str(table.get("operation", "")), place.key("operation"))
    settings = {key: value for key, value in table.items() if key != "operation"}
    return read_table(kind, settings, place)
