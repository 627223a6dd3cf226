"""Every search by its name; the module of each is loaded when it is asked for."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import cast

from morph.body.robot import Robot
from morph.errors import SearchError
from morph.nearest import nearest
from morph.search.search import Search

SEARCHES: Mapping[str, str] = {
    "chance": "morph.search.evolution:RandomSearch",
    "cmaes": "morph.search.cmaes:CmaEs",
    "ddp": "morph.search.ddp:Plan",
    "evolution": "morph.search.evolution:Evolution",
    "gp-ddp": "morph.search.gp_ddp:LearnedPlans",
    "lqr": "morph.search.lqr:Lqr",
    "mc-pilco": "morph.search.mc_pilco:McPilco",
    "pddp": "morph.search.pddp:Pddp",
    "pilco": "morph.search.pilco:Pilco",
    "receding": "morph.search.receding:Receding",
}
"""Module and class of each search, by its name; several import torch, which takes seconds."""

DEFAULTS: Mapping[str, str] = {"balance": "lqr", "ride": "lqr", "swing-up": "ddp"}
"""Which search is tried where none is named, by the task; for the others the next."""

OTHERWISE = "cmaes"
"""What asks least of a task: it only tries."""


def default(task: str, robot: Robot | None = None) -> str:
    """Return the name of the search that suits a task, or that task of a robot.

    Regulators and plans know joints alone: what floats or stands on a floor is tried out.
    """
    floats = robot is not None and any(joint.kind == "free" for joint in robot.joints)
    return OTHERWISE if floats else DEFAULTS.get(task, OTHERWISE)


def search(name: str) -> type[Search]:
    """Return the class of a search by its name.

    Raises:
        SearchError: There is no such search.
    """
    if name not in SEARCHES:
        raise SearchError(
            f"there is no search {name!r}; there are {', '.join(SEARCHES)}",
            where="morph.search",
            fix=f"the nearest are {nearest(name, SEARCHES)}",
        )
    module, _, attribute = SEARCHES[name].partition(":")
    return cast(type[Search], getattr(importlib.import_module(module), attribute))
