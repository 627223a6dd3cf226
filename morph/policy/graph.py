"""A graph of ONNX under construction: numbers and operations, each named by what it gives."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.arrays import Array, Integers

OPSET = 17
"""Version of ONNX's operators: what runtimes of the last years know."""

IR_VERSION = 8
"""Version of its files that goes with them."""


class Graph:
    """Operations from `observation` (rows, observations) and `time` (rows,) to `action`."""

    def __init__(self) -> None:
        self._nodes: list[Any] = []
        self._numbers: list[Any] = []

    def number(self, value: Any) -> str:
        """Return the name of numbers that never change; floats stay float64, integers int64."""
        from onnx import numpy_helper

        array = np.asarray(value)
        name = f"number.{len(self._numbers)}"
        self._numbers.append(numpy_helper.from_array(np.array(array, order="C"), name))
        return name

    def node(
        self, operator: str, *inputs: str | Array | Integers | float, **attributes: Any
    ) -> str:
        """Return the name of what an operator gives; inputs that are no names are numbers."""
        from onnx import helper

        names = [each if isinstance(each, str) else self.number(each) for each in inputs]
        name = f"value.{len(self._nodes)}"
        self._nodes.append(helper.make_node(operator, names, [name], **attributes))
        return name

    def within(self, x: str, low: Array | float, high: Array | float) -> str:
        """Return the name of x between its least and its greatest."""
        return self.node("Min", self.node("Max", x, low), high)

    def model(self, action: str, *, seen: int, command: int, metadata: dict[str, str]) -> Any:
        """Return the whole as an `onnx.ModelProto`, checked by ONNX itself.

        Args:
            action: The name of what is commanded.
            seen: How many numbers are seen.
            command: How many are commanded.
            metadata: Texts by name that go with it.
        """
        import onnx
        from onnx import helper

        double = onnx.TensorProto.DOUBLE
        shapes: dict[str, list[str | int | None]] = {
            "observation": ["rows", seen],
            "time": ["rows"],
            "action": ["rows", command],
        }
        ends = {
            name: helper.make_tensor_value_info(name, double, shape)
            for name, shape in shapes.items()
        }
        last = helper.make_node("Identity", [action], ["action"])
        graph = helper.make_graph(
            [*self._nodes, last],
            "policy",
            [ends["observation"], ends["time"]],
            [ends["action"]],
            self._numbers,
        )
        model = helper.make_model(
            graph,
            producer_name="morph",
            ir_version=IR_VERSION,
            opset_imports=[helper.make_opsetid("", OPSET)],
        )
        helper.set_model_props(model, metadata)
        onnx.checker.check_model(model, full_check=True)
        return model
