"""The errors of the benchmark."""

from __future__ import annotations

from morph.errors import MorphError


class BenchmarkError(MorphError):
    """A case, a submission or a truth cannot be used."""


class CompilerError(MorphError):
    """The generator's dynamics cannot be compiled."""
