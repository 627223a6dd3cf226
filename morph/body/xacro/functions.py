"""What expressions of xacro may call, and how large a value may become."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

LONGEST_TEXT = 2**20
"""Characters and items in a value, all its parts together."""

LARGEST_BITS = 2048
"""Bits of an integer; the greatest float has 1024."""

UNBOUNDED = {"comb", "factorial", "lcm", "ldexp", "perm", "prod", "fsum", "gcd", "isqrt"}
"""Functions of `math` whose work or result grows without bound."""


def bounded(value: Any, times: int = 1) -> int:
    """Return the size of a value: its characters, items and words of bits.

    Raises:
        ValueError: It is larger than any description needs, or something other than
            numbers and texts.
    """
    size, left = 0, [value]
    while left:
        part = left.pop()
        if isinstance(part, str):
            size += len(part)
        elif isinstance(part, int) and part.bit_length() > LARGEST_BITS:
            raise ValueError(f"it comes to an integer of {part.bit_length()} bits")
        elif type(part) in (list, tuple):
            size += len(part)
            left += part
        elif type(part) is dict:
            size += 2 * len(part)
            left += [*part, *part.values()]
        elif part is not None and not isinstance(part, (int, float)):
            raise ValueError(f"it comes to a {type(part).__name__}")
        size += 1
        if (size + len(left)) * times > LONGEST_TEXT:
            raise ValueError(f"it comes to more than {LONGEST_TEXT} characters or items")
    return size


def _round(number: float, digits: int = 0) -> float:
    if abs(digits) > 400:
        raise ValueError("it rounds to more than 400 digits")
    return round(number, digits) if digits else round(number)


def _range(*ends: int) -> list[int]:
    whole = range(*ends)
    if len(whole) > 10_000:
        raise ValueError("a range has more than 10000 items")
    return list(whole)


def _sum(items: Any, start: float = 0.0) -> float:
    if not all(isinstance(item, (int, float)) for item in items):
        raise TypeError("sum takes numbers")
    return sum(items, start) if start else sum(items)


def _float(value: Any = 0.0) -> float:
    return float(value)


def _tokenize(text: str, separators: str = ",; ", skip_empty: bool = True) -> list[str]:
    """Return the pieces of a text between separators, as `xacro.tokenize` does."""
    if len(separators) > 16:
        raise ValueError("tokenize takes 16 separators at most")
    for each in separators:
        text = text.replace(each, "\0")
    return [piece for piece in text.split("\0") if piece or not skip_empty]


def _arithmetic() -> dict[str, Callable[..., Any]]:
    return {
        name: each
        for name, each in vars(math).items()
        if callable(each) and not name.startswith("_") and name not in UNBOUNDED
    }


BUILTIN: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "all": all,
    "any": any,
    "bool": bool,
    "dict": dict,
    "divmod": divmod,
    "enumerate": lambda items, start=0: [list(pair) for pair in enumerate(items, start)],
    "float": _float,
    "int": int,
    "len": len,
    "list": list,
    "max": max,
    "min": min,
    "ord": ord,
    "range": _range,
    "reversed": lambda items: list(reversed(items)),
    "round": _round,
    "sorted": sorted,
    "str": str,
    "sum": _sum,
    "tuple": tuple,
    "zip": lambda *items: [list(pair) for pair in zip(*items, strict=False)],
}

LOCAL = ("load_yaml", "abs_filename", "arg", "find", "dirname", "env", "optenv", "fatal")
"""Functions that need to know where they stand; `Evaluator` is given them."""

XACRO: dict[str, Callable[..., Any] | None] = {
    **dict.fromkeys(LOCAL),
    "dotify": dict,
    "error": lambda *_: "",
    "message": lambda *_: "",
    "print_location": lambda *_: "",
    "tokenize": _tokenize,
    "warning": lambda *_: "",
}

FUNCTIONS: Mapping[str, Callable[..., Any] | None] = {**_arithmetic(), **BUILTIN, **XACRO}
"""All that may be called, by name."""

NAMESPACES: Mapping[str, frozenset[str]] = {
    "math": frozenset(_arithmetic()),
    "python": frozenset(BUILTIN),
    "xacro": frozenset(XACRO),
}
"""The same, by the prefix that xacro knows them under."""

CONSTANTS: Mapping[str, Any] = {
    **{name: each for name, each in vars(math).items() if isinstance(each, float)},
    "True": True,
    "False": False,
    "true": True,
    "false": False,
}
"""Numbers with a name."""
