"""Expressions of xacro, worked out by hand: arithmetic and text within bounds, nothing else."""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from morph.body.xacro.functions import (
    CONSTANTS,
    FUNCTIONS,
    NAMESPACES,
    bounded,
)
from morph.errors import RobotError

LONGEST = 4000
"""Characters in an expression; real ones have some hundred."""

DEEPEST = 150
"""Brackets and operators inside each other; a sum of many terms counts as many."""

Symbols = Mapping[str, Any]
"""What a name stands for: properties, parameters, arguments."""

CONTAINERS = (ast.List, ast.Tuple, ast.Dict)

BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}

UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
}

COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda one, other: one in other,
    ast.NotIn: lambda one, other: one not in other,
}

FORMS = (
    *(ast.Expression, ast.Load, ast.Name, ast.Constant, ast.BinOp, ast.UnaryOp, ast.BoolOp),
    *(ast.And, ast.Or, ast.Compare, ast.IfExp, ast.Subscript, ast.Slice, ast.Call, ast.Attribute),
    *(*CONTAINERS, *BINARY, *UNARY, *COMPARE),
)
"""All that an expression may be made of."""


def checked(text: str, where: str) -> ast.expr:
    """Return an expression as a tree of harmless parts.

    Raises:
        RobotError: It is no expression, too long or too deep, or has a part
            that could do more than reckon: another call, a loop, a hidden name.
    """
    try:
        return _tree(text)
    except ValueError as error:
        raise refused(text, str(error), where) from error


def refused(text: str, why: str, where: str) -> RobotError:
    """Return the error for an expression that cannot be worked out."""
    shown = text if len(text) < 80 else text[:80] + "…"
    return RobotError(
        f"has the expression {shown!r}, and {why}",
        where=where,
        fix="use numbers, texts, lists, properties, + - * / // % **, comparisons, "
        "`a if b else c` and xacro's mathematical functions",
    )


@lru_cache(maxsize=4096)
def _tree(text: str) -> ast.expr:
    if len(text) > LONGEST:
        raise ValueError(f"it has {len(text)} characters; {LONGEST} are allowed")
    try:
        with warnings.catch_warnings():
            # Python warns of odd spellings, such as an unknown escape in a text.
            warnings.simplefilter("ignore")
            tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError) as error:
        raise ValueError(f"that is none: {str(error).partition('(')[0].strip()}") from error
    except (MemoryError, RecursionError) as error:
        raise ValueError("it nests too deep") from error
    level: list[ast.AST] = [tree]
    for _ in range(DEEPEST):
        for node in level:
            _harmless(node)
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        if not level:
            return tree
    raise ValueError("it nests too deep")


def _harmless(node: ast.AST) -> None:
    if isinstance(node, ast.keyword) and node.arg is not None:
        return
    if not isinstance(node, FORMS):
        raise ValueError(f"{type(node).__name__} is not allowed in it")
    if isinstance(node, ast.Name) and node.id.startswith("__"):
        raise ValueError(f"the name {node.id!r} is not allowed in it")
    if isinstance(node, ast.Attribute) and node.attr.startswith("_"):
        raise ValueError(f"the name {node.attr!r} is not allowed in it")
    if isinstance(node, ast.Constant):
        if not isinstance(node.value, (str, int, float, type(None))):
            raise ValueError(f"{node.value!r} is not allowed in it")
        bounded(node.value)
    if isinstance(node, ast.Dict) and None in node.keys:
        raise ValueError("** is not allowed in it")
    if isinstance(node, ast.Call):
        name = _called(node.func)
        if name not in FUNCTIONS:
            raise ValueError(f"{name or 'that'!r} is no function that it may call")
        if node.keywords and name != "dict":
            raise ValueError(f"{name} takes no names of arguments")


def _called(function: ast.expr) -> str:
    if isinstance(function, ast.Name):
        return function.id
    if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name):
        space, name = function.value.id, function.attr
        return name if name in NAMESPACES.get(space, ()) else f"{space}.{name}"
    return ""


class Evaluator:
    """Works out expressions.

    Args:
        local: Functions that need to know where they stand, such as `load_yaml`.
        spend: Told how much each step costs; may raise to stop.
    """

    def __init__(
        self, local: Mapping[str, Callable[..., Any]], spend: Callable[[int], None]
    ) -> None:
        self.functions = {**{name: each for name, each in FUNCTIONS.items() if each}, **local}
        self.spend = spend

    def value(self, text: str, symbols: Symbols, where: str) -> Any:
        """Return what an expression comes to.

        Raises:
            RobotError: It is not allowed, or comes to nothing.
        """
        tree = checked(text, where)
        try:
            return self._value(tree, symbols)
        except KeyError as error:
            raise refused(text, f"nothing is called {error.args[0]!r}", where) from error
        except RecursionError as error:
            raise refused(text, "it leads on and on", where) from error
        except (ArithmeticError, IndexError, TypeError, ValueError, AttributeError) as error:
            raise refused(text, str(error) or "it comes to nothing", where) from error

    def _value(self, node: ast.expr, symbols: Symbols) -> Any:
        self.spend(1)
        value = self._raw(node, symbols)
        size = bounded(value)
        self.spend(size // 1024 if isinstance(value, str) else size // 2)
        return value

    def _raw(self, node: ast.expr, symbols: Symbols) -> Any:
        match node:
            case ast.Constant(value=value):
                return value
            case ast.Name(id=name):
                return symbols[name] if name in symbols else CONSTANTS[name]
            case ast.BinOp(left=left, op=op, right=right):
                return _binary(op, self._value(left, symbols), self._value(right, symbols))
            case ast.UnaryOp(op=sign, operand=operand):
                return UNARY[type(sign)](self._value(operand, symbols))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self._value(body if self._value(test, symbols) else orelse, symbols)
            case ast.Attribute(value=ast.Name(id=name), attr=attr) if (
                name in NAMESPACES and name not in symbols
            ):
                return CONSTANTS[attr]
            case ast.Attribute(value=owner, attr=attr):
                # The owner may be a namespace, which is no value by itself.
                return _item(self._raw(owner, symbols), attr)
            case ast.Subscript(value=owner, slice=key):
                return _item(self._value(owner, symbols), self._key(key, symbols))
            case _:
                return self._compound(node, symbols)

    def _compound(self, node: ast.expr, symbols: Symbols) -> Any:
        match node:
            case ast.BoolOp(op=op, values=values):
                result = None
                for each in values:
                    result = self._value(each, symbols)
                    if bool(result) == isinstance(op, ast.Or):
                        break
                return result
            case ast.Compare(left=left, ops=ops, comparators=others):
                one = self._value(left, symbols)
                for sign, other in zip(ops, others, strict=True):
                    right = self._value(other, symbols)
                    if not COMPARE[type(sign)](one, right):
                        return False
                    one = right
                return True
            case ast.List(elts=items) | ast.Tuple(elts=items):
                kind = list if isinstance(node, ast.List) else tuple
                return kind(self._value(item, symbols) for item in items)
            case ast.Dict(keys=keys, values=values):
                return {
                    self._value(key, symbols): self._value(value, symbols)
                    for key, value in zip(keys, values, strict=True)
                    if key is not None
                }
            case ast.Call(func=function, args=arguments, keywords=named):
                return self.functions[_called(function)](
                    *(self._value(each, symbols) for each in arguments),
                    **{each.arg or "": self._value(each.value, symbols) for each in named},
                )
        raise ValueError(f"{type(node).__name__} is not allowed in it")

    def _key(self, node: ast.expr, symbols: Symbols) -> Any:
        if isinstance(node, ast.Slice):
            ends = (node.lower, node.upper, node.step)
            return slice(*(self._value(end, symbols) if end else None for end in ends))
        return self._value(node, symbols)


def _item(owner: Any, key: Any) -> Any:
    if isinstance(owner, (dict, list, tuple, str)):
        return owner[key]
    raise TypeError(f"a {type(owner).__name__} has no parts")


def _binary(op: ast.operator, one: Any, other: Any) -> Any:
    numbers = isinstance(one, (int, float)) and isinstance(other, (int, float))
    if isinstance(op, ast.Pow) and isinstance(one, int) and isinstance(other, int):
        # Bits of the result, before there is one.
        if abs(one) > 1 and one.bit_length() * abs(other) > 4096:
            return math.pow(one, other)
    elif isinstance(op, ast.Mult) and not numbers:
        times = other if isinstance(other, int) else one
        content = one if times is other else other
        if isinstance(times, int) and isinstance(content, (str, list, tuple)):
            bounded(content, times=max(times, 0))
    elif isinstance(op, ast.Add) and not numbers:
        if not isinstance(one, (str, list, tuple)) or type(one) is not type(other):
            raise TypeError(f"a {type(one).__name__} and a {type(other).__name__} do not add up")
    elif not numbers:
        raise TypeError(f"{type(op).__name__} takes numbers")
    return BINARY[type(op)](one, other)
