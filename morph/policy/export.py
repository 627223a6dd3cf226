"""A policy as `policy.onnx`, for controllers without Python: the same numbers, law and metadata."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.files import write_whole
from morph.policy.adjusted import Adjusted
from morph.policy.bound import Bound
from morph.policy.feedback import Feedback
from morph.policy.files import EXPORTED, read_json
from morph.policy.graph import Graph
from morph.policy.linear import Linear
from morph.policy.network import Network
from morph.policy.pattern import Pattern
from morph.policy.policy import LARGEST, Policy
from morph.policy.policy_json import check_body, said_of
from morph.policy.radial import Radial
from morph.policy.replay import TOLERANCE, apart, to_replay
from morph.policy.store import load_policy
from morph.policy.track import Track

METADATA = "policy.json"
"""Name of the metadata of the exported model: the text of that file."""


def export_policy(folder: str | Path, robot: Robot) -> Path:
    """Return the `policy.onnx` that the policy of a folder was exported to, beside it.

    Raises:
        PolicyError: The folder holds no policy of this robot, or it cannot be exported.
        OutputError: The folder cannot be written to.
    """
    policy = load_policy(folder, robot)
    document = read_json(Path(folder) / "policy.json")
    return export_onnx(policy, Path(folder) / EXPORTED, robot, document=document)


def export_onnx(policy: Policy, path: Path, robot: Robot, *, document: JSON | None = None) -> Path:
    """Return the file that a policy was exported to.

    Its inputs are `observation`, shape (rows, observations), offset, scaled, delayed and with
    its history as the metadata say, and `time`, s, shape (rows,), a multiple of the control
    period; its output is `action`, shape (rows, actions); all float64.

    Args:
        policy: What to export.
        path: The file to write.
        robot: The body that it commands.
        document: What its `policy.json` says; None to say it anew.

    Raises:
        PolicyError: It does not command this robot, or the model acts otherwise.
        OutputError: The file cannot be written.
    """
    check_body(policy, robot, where=str(path))
    if document is None:
        document = said_of(policy, robot, task="", task_sha256="", learned=None)
    model = onnx_of(policy, json.dumps(document, indent=1))
    _check(model, policy, where=str(path))
    write_whole(path, model.SerializeToString(deterministic=True))
    return path


def onnx_of(policy: Policy, metadata: str = "") -> Any:
    """Return a policy as an `onnx.ModelProto`.

    Raises:
        PolicyError: Its kind has no law in ONNX.
    """
    law = LAWS.get(type(policy))
    if law is None:
        raise PolicyError(
            f"a policy of kind {policy.kind} cannot be exported",
            where="policy.onnx",
            fix=f"export one of {', '.join(kind.kind for kind in LAWS)}",
        )
    graph = Graph()
    action = law(graph, policy)
    texts = {METADATA: metadata} if metadata else {}
    return graph.model(action, seen=policy.size, command=len(policy.action), metadata=texts)


def _check(model: Any, policy: Policy, *, where: str) -> None:
    """Replay the model by ONNX's own evaluator, which shares nothing with the policy."""
    from onnx.reference import ReferenceEvaluator

    replay = to_replay(policy, seconds=10.0, observed=None, times=None)
    given = {name: replay[f"replay.{name}"] for name in ("observation", "time")}
    (again,) = ReferenceEvaluator(model).run(None, given)
    worst = apart(np.asarray(again), replay["replay.action"])
    if not worst <= TOLERANCE:
        raise PolicyError(
            f"the exported model's actions differ from the policy's by {worst:.2g}",
            where=where,
            fix="tell morph's authors which policy it was",
        )


def _pattern(graph: Graph, policy: Pattern) -> str:
    n = policy.weights()
    t = graph.node("Unsqueeze", "time", np.array([1]))
    angle = graph.node("Add", graph.node("Mul", t, 2.0 * math.pi * n["frequency"]), n["phase"])
    swing = graph.node("Mul", graph.node("Sin", angle), n["amplitude"])
    middle = graph.node("Add", graph.node("Mul", t, n["rate"]), n["offset"])
    return _bounded(graph, graph.node("Add", middle, swing), policy.limited)


def _linear(graph: Graph, policy: Linear) -> str:
    x = _affine(graph, _features(graph, policy), policy.weight, policy.bias)
    return _bounded(graph, x, policy.limited)


def _radial(graph: Graph, policy: Radial) -> str:
    middle, centre, half = policy.scaled
    away = graph.node("Div", graph.node("Sub", _features(graph, policy), middle), policy.width)
    near = _near(graph, graph.within(away, -LARGEST, LARGEST), centre, half)
    return _bounded(graph, graph.node("MatMul", near, policy.weight.T), policy.limited)


def _near(graph: Graph, x: str, centre: Array, half: Array) -> str:
    """Return the name of what radial functions give at x, in widths about their middle."""
    square = graph.node("ReduceSum", graph.node("Mul", x, x), np.array([1]), keepdims=1)
    power = graph.node("Sub", graph.node("MatMul", x, centre.T), half)
    power = graph.node("Sub", power, graph.node("Mul", square, 0.5))
    return graph.node("Exp", graph.node("Min", power, 0.0))


def _network(graph: Graph, policy: Network) -> str:
    x = _features(graph, policy)
    for weight, bias in policy.layers[:-1]:
        x = graph.node("Tanh", _affine(graph, x, weight, bias))
    return _bounded(graph, _affine(graph, x, *policy.layers[-1]), policy.limited)


def _track(graph: Graph, policy: Track) -> str:
    at = graph.node("Add", graph.node("Div", "time", policy.period), 1e-6)
    at = graph.within(graph.node("Floor", at), 0.0, float(len(policy.nominal) - 1))
    knot = graph.node("Cast", at, to=7)  # int64
    seen = graph.within("observation", -LARGEST, LARGEST)
    away = graph.node("Sub", seen, graph.node("Gather", policy.nominal, knot))
    turns = graph.node("Floor", graph.node("Add", graph.node("Div", away, 2.0 * math.pi), 0.5))
    whole = graph.node("Mul", turns, 2.0 * math.pi * np.asarray(policy.angles))
    away = graph.node("Unsqueeze", graph.node("Sub", away, whole), np.array([2]))
    more = graph.node("MatMul", graph.node("Gather", policy.gain, knot), away)
    more = graph.node("Squeeze", more, np.array([2]))
    command = graph.node("Add", more, graph.node("Gather", policy.command, knot))
    return _bounded(graph, command, policy.limited)


def _adjusted(graph: Graph, policy: Adjusted) -> str:
    command = LAWS[type(policy.source)](graph, policy.source)
    z = graph.node("Concat", _features(graph, policy), command, axis=1)
    added = _affine(graph, graph.within(z, -policy.reach, policy.reach), policy.law, policy.bias)
    middle, parts = policy.scaled
    rest = []
    for at, (centre, half) in enumerate(parts):
        away = graph.node("Div", graph.node("Sub", z, middle), policy.width[at])
        near = _near(graph, graph.within(away, -LARGEST, LARGEST), centre, half)
        rest.append(graph.node("MatMul", near, policy.weight[at][:, None]))
    added = graph.node("Add", added, graph.node("Concat", *rest, axis=1))
    return _bounded(graph, graph.node("Add", command, added), policy.limited)


LAWS: dict[type[Policy], Callable[[Graph, Any], str]] = {
    Pattern: _pattern,
    Linear: _linear,
    Radial: _radial,
    Network: _network,
    Track: _track,
    Adjusted: _adjusted,
}
"""What each kind is in ONNX, readably and apart from the kind's own code."""


def _features(graph: Graph, policy: Feedback | Adjusted) -> str:
    seen = graph.within("observation", -LARGEST, LARGEST)
    if isinstance(policy, Adjusted):
        seen = graph.node("Gather", seen, policy.newest, axis=1)
    plain, angles = policy.seen
    if not len(angles):
        return seen
    turned = graph.node("Gather", seen, angles, axis=1)
    parts = [graph.node("Sin", turned), graph.node("Cos", turned)]
    if len(plain):
        parts.insert(0, graph.node("Gather", seen, plain, axis=1))
    # All sines, then all cosines; wanted are the two of each angle in turn.
    pairs = np.arange(2 * len(angles)).reshape(2, -1).T.ravel() + len(plain)
    order = np.concatenate([np.arange(len(plain)), pairs])
    return graph.node("Gather", graph.node("Concat", *parts, axis=1), order, axis=1)


def _affine(graph: Graph, x: str, weight: Array, bias: Array) -> str:
    return graph.node("Add", graph.node("MatMul", x, weight.T), bias)


def _bounded(graph: Graph, x: str, bound: Bound) -> str:
    if bound.how != "clip":
        if bound.how == "sine":
            s = graph.node("Sin", x)
            less = graph.node("Mul", graph.node("Mul", s, s), 0.5)
            x = graph.node("Mul", s, graph.node("Sub", 1.5, less))
        else:
            x = graph.node("Tanh", x)
        middle, half = (bound.low + bound.high) / 2.0, (bound.high - bound.low) / 2.0
        x = graph.node("Add", graph.node("Mul", x, half), middle)
    return graph.within(x, bound.low, bound.high)
