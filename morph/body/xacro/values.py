"""What expressions and commands of xacro may ask of their surroundings."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from morph.body.xacro.check import unknown_command
from morph.body.xacro.expression import Evaluator
from morph.body.xacro.folder import Folder
from morph.errors import RobotError

LONGEST_YAML = 2**18
"""Bytes in a file of YAML."""

DEEPEST_YAML = 50
"""Lists and tables inside each other."""

UNITS = {
    "!radians": "1.0",
    "!degrees": "pi / 180",
    "!meters": "1.0",
    "!millimeters": "0.001",
    "!foot": "0.3048",
    "!inches": "0.0254",
}
"""Units that xacro knows in YAML, in SI."""

Here = Callable[[], Path]
"""Tells the file that is being expanded."""


class Surroundings:
    """The commands and functions that look outside an expression.

    Args:
        folder: What may be read.
        arguments: The values of `$(arg name)`; xacro adds the defaults.
        here: Tells the file that is being expanded.
        where: Tells the file and the line.
    """

    def __init__(
        self, folder: Folder, arguments: dict[str, str], here: Here, where: Callable[[], str]
    ) -> None:
        self.folder, self.arguments, self.here, self.where = folder, arguments, here, where
        self.evaluator: Evaluator | None = None

    def functions(self) -> dict[str, Callable[..., Any]]:
        """Return the functions of `LOCAL`."""
        return {
            "abs_filename": lambda name: str(self.here().parent / str(name)),
            "arg": lambda name: argument_value(self.argument(str(name))),
            "dirname": lambda: str(self.here().parent),
            "env": self.environment,
            "fatal": self.fatal,
            "find": lambda name: str(self.folder.package(str(name), self.where())),
            "load_yaml": self.load_yaml,
            "optenv": lambda name, default="": default,
        }

    def command(self, text: str) -> str:
        """Return what `$(text)` stands for.

        Raises:
            RobotError: It is unknown, or asks for what is not there.
        """
        match text.split():
            case ["arg", name]:
                return str(self.argument(name))
            case ["find", name]:
                return str(self.folder.package(name, self.where()))
            case ["dirname"]:
                return str(self.here().parent)
            case ["optenv", _, *default]:
                # A description is the same on every machine.
                return " ".join(default)
            case ["eval", *_] if self.evaluator is not None:
                values = {name: argument_value(each) for name, each in self.arguments.items()}
                code = text.strip().removeprefix("eval")
                return str(self.evaluator.value(code, values, self.where()))
        raise unknown_command(text, self.where())

    def argument(self, name: str) -> str:
        """Return an argument; RobotError if nobody gave it."""
        if name not in self.arguments:
            known = ", ".join(sorted(self.arguments)) or "none"
            raise RobotError(
                f"needs an argument {name[:80]!r}, and there are {known[:200]}",
                where=self.where(),
                fix=f'give it a default: <xacro:arg name="{name[:80]}" default="..."/>',
            )
        return self.arguments[name]

    def environment(self, name: object) -> str:
        """Refuse to read the environment."""
        raise unknown_command(f"env {name!s:.60}", self.where())

    def fatal(self, *what: object) -> str:
        """Stop, as the description asks for."""
        text = " ".join(f"{each!s:.200}" for each in what[:10])
        raise RobotError(
            f"stops itself: {text}", where=self.where(), fix="do what its author asks for"
        )

    def load_yaml(self, name: object) -> Any:
        """Return the numbers, texts, lists and tables in a file of the folder."""
        (path, *_) = self.folder.matches(str(name), self.here().parent, self.where()) or [Path()]
        try:
            content = self.folder.read(path, self.where())
            if len(content) > LONGEST_YAML:
                raise ValueError(f"it has more than {LONGEST_YAML} bytes")
            return self._units(yaml.compose(_flat(content), Loader=yaml.SafeLoader))
        except FileNotFoundError as error:
            raise _bad_yaml(str(path), "it is not there", self.where()) from error
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            raise _bad_yaml(str(path), " ".join(str(error).split()), self.where()) from error

    def _units(self, node: yaml.Node | None) -> Any:
        """Return the value of a node; what bears a unit is reckoned in SI."""
        if isinstance(node, yaml.SequenceNode):
            return [self._units(each) for each in node.value]
        if isinstance(node, yaml.MappingNode):
            pairs = [(self._units(key), self._units(value)) for key, value in node.value]
            if not all(isinstance(key, (str, int, float)) for key, _ in pairs):
                raise ValueError("a key is neither text nor number")
            return dict(pairs)
        if isinstance(node, yaml.ScalarNode):
            if node.tag in UNITS and self.evaluator is not None:
                code = f"({node.value}) * {UNITS[node.tag]}"
                return float(self.evaluator.value(code, {}, self.where()))
            return _scalar(node)
        return None


def _flat(content: bytes) -> str:
    """Return a text of YAML that is neither deep nor repeats parts of itself."""
    text, depth = content.decode(), 0
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        if isinstance(event, yaml.AliasEvent):
            raise ValueError("it repeats parts of itself (*alias)")
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST_YAML:
            raise ValueError(f"it nests deeper than {DEEPEST_YAML}")
    return text


def _scalar(node: yaml.ScalarNode) -> Any:
    loader = yaml.SafeLoader("")
    try:
        value = loader.construct_object(node)
    finally:
        loader.dispose()
    return value if isinstance(value, (str, int, float, type(None))) else str(node.value)


def argument_value(text: str) -> Any:
    """Return an argument as `$(eval ...)` sees it: a number or a truth if it reads like one."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return {"true": True, "false": False}.get(text.lower(), text)


def _bad_yaml(name: str, why: str, where: str) -> RobotError:
    return RobotError(
        f"loads {name!r}, and {why[:300]}", where=where, fix="give a plain file of YAML in UTF-8"
    )
