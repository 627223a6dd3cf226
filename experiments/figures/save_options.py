"""`--save` and `--save-as` of studies: listed settings replace the stated result, others do not."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from experiments.figures.catalogue import CATALOGUE, PYTHON, Study, load_catalogue
from experiments.figures.result_file import RESULTS, Start, result_path, save_result
from morph.errors import OutputError
from morph.regular_file import open_regular

RUNNING = frozenset(
    {"engine", "workers", "scheduler", "resume", "fresh", "stale", "out", "json", "plot", "quiet"}
    | {"save", "save_as"}
)
"""Options that decide how a study runs and what it prints, not what it measures."""


@dataclass(frozen=True, kw_only=True)
class Save:
    """Callable that writes a study's result file; false where the user asked for none."""

    to: str | Path | None
    """Name of a listed study, path of another file, or None to write nothing."""
    command: str
    """Command that runs the study again, from `experiments.` on."""
    settings: Mapping[str, Any]
    """Every option that decides what is measured."""
    start: Start | None
    """Code and clocks at the start; None if nothing is written."""

    def __bool__(self) -> bool:
        return self.to is not None

    def __call__(
        self,
        *,
        figures: Mapping[str, Any],
        controls: Mapping[str, Any],
        rows: Sequence[Mapping[str, Any]] = (),
        seeds: Sequence[int] = (),
    ) -> Path:
        """Write the result file by `save_result` of `result_file.py`, and return its path.

        Raises:
            ValueError: The user asked for no result: test `if save:` first.
            StudyError: The result is not as `save_result` wants it.
            OutputError: The file cannot be written.
        """
        if self.to is None or self.start is None:
            raise ValueError("there is nowhere to save to: test `if save:` first")
        return save_result(
            self.to,
            start=self.start,
            command=self.command,
            settings=self.settings,
            seeds=seeds,
            figures=figures,
            controls=controls,
            rows=rows,
        )


def parse_and_save(
    parser: argparse.ArgumentParser,
    arguments: Sequence[str] | None,
    *,
    module: str,
    catalogue: Path = CATALOGUE,
) -> tuple[argparse.Namespace, Save]:
    """Add `--save` and `--save-as` to a parser, parse, and return the options and a `Save`.

    The program ends with status 2 before anything is measured where `--save` is given with other
    settings than the catalogue's, so that a quick run never replaces a stated figure, or where
    the file cannot be written.

    Args:
        parser: Parser of the study, complete but for these two options.
        arguments: Arguments of `main`; None for those of the command line.
        module: Dotted name of the study's module (`__name__` is `__main__` there).
        catalogue: File that lists the studies.

    Raises:
        StudyError: The catalogue or the module cannot be used.
    """
    _add_options(parser)
    options = parser.parse_args(arguments)
    settings = _settings(options)
    if not options.save and options.save_as is None:
        return options, Save(to=None, command="", settings=settings, start=None)
    name = module.removesuffix(".__main__")
    listed = [each for each in load_catalogue(catalogue)[0] if each.module == name]
    same = [
        each
        for each in listed
        if _settings(parser.parse_args(shlex.split(each.command)[1:])) == settings
    ]
    _check(parser, options, listed=listed, same=same)
    given = sys.argv[1:] if arguments is None else arguments
    to = same[0].name if options.save else options.save_as
    try:
        check_writable(to if isinstance(to, Path) else result_path(to))
    except OutputError as error:
        parser.error(str(error))
    if options.save:
        _use_own_folder(options, parser.get_default("out"), same[0].name)
    return options, Save(
        to=to,
        command=same[0].command if same else _command(name, given),
        settings=settings,
        start=replace(Start.now(module), resumed=getattr(options, "resume", False)),
    )


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--save",
        action="store_true",
        help="write experiments/results/NAME.json; only for the settings of figures.toml",
    )
    parser.add_argument(
        "--save-as", type=Path, metavar="FILE", help="write the result of any settings here"
    )


def _check(
    parser: argparse.ArgumentParser,
    options: argparse.Namespace,
    *,
    listed: Sequence[Study],
    same: Sequence[Study],
) -> None:
    """End the program where the result must not be saved with these options."""
    if getattr(options, "stale", None) == "keep":
        parser.error("all rows of a result must be of the same code: use --stale rerun, not keep")
    if options.save and not same:
        known = "; ".join(f"{PYTHON} {each.command} --save" for each in listed) or "none"
        parser.error(
            f"--save is for the settings that figures.toml lists ({known}); "
            "write the result of others with --save-as FILE"
        )
    if options.save_as is not None and options.save_as.resolve().parent == RESULTS:
        parser.error(
            "--save-as writes outside experiments/results; files there are written by --save"
        )
    if options.save_as is not None and not is_replaceable(options.save_as):
        parser.error(f"{options.save_as} is no earlier result: name a new file by --save-as")


def is_replaceable(path: Path) -> bool:
    """Return whether a result may be written to a path: nothing is there, or an earlier result."""
    if not os.path.lexists(path):
        return True
    try:
        with open_regular(path) as file:
            return b'"schema": "morph.result/' in file.read(200)
    except OSError:
        # What is no regular file is refused by `check_writable`, which says why.
        return not path.is_file()


def check_writable(path: Path) -> None:
    """Check that a file can be written, before hours of measuring; an existing file stays.

    Raises:
        OutputError: The folder cannot be made or written to, or the path is no regular file.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}."):
            pass
        if path.exists() and not path.is_file():
            raise OSError("it is no regular file")
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}",
            where=str(path),
            fix="choose a folder that exists, can be written to and has room",
        ) from error


def _use_own_folder(options: argparse.Namespace, out: Path | None, name: str) -> None:
    """Give a listed study a folder of its own, and resume from rows of the same code in it."""
    if out is None or options.out != out or "resume" not in options:
        return
    options.out = out.with_name(name)
    if not options.fresh and options.out.is_dir():
        options.resume, options.stale = True, "rerun"


def _settings(options: argparse.Namespace) -> dict[str, Any]:
    return {name: value for name, value in vars(options).items() if name not in RUNNING}


def _command(name: str, given: Sequence[str]) -> str:
    """Return the command as it was given, without --save-as."""
    left = list(given)
    if "--save-as" in left:
        place = left.index("--save-as")
        del left[place : place + 2]
    return shlex.join([name, *left])
