"""Engine that runs calls in this process, one after the other, for a debugger."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import ClassVar, ParamSpec, TypeVar

from morph.study.engine import Engine, EngineName

P = ParamSpec("P")
T = TypeVar("T")


class InlineEngine(Engine):
    """Runs each call inside `submit`, which returns a finished future."""

    name: ClassVar[EngineName] = "inline"
    own_process: ClassVar[bool] = False

    def slots(self) -> int:
        """Return 1."""
        return 1

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return the finished future of a call."""
        future: Future[T] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Do nothing: every call has ended already."""
