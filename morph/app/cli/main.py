"""The command `morph`: what it is asked, what it answers, and its exit status."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from io import TextIOWrapper
from typing import Annotated

import tyro

import morph
from morph.alignment.errors import AlignError
from morph.app.cli.align_arguments import Align, Transfer
from morph.app.cli.arguments import (
    Compare,
    Convert,
    Diagnose,
    Inspect,
    Learn,
    List,
    Loop,
)
from morph.app.cli.console import harmless
from morph.app.cli.excite_arguments import Excite
from morph.app.cli.print_arguments import Print
from morph.app.cli.simulate_arguments import Simulate
from morph.app.cli.study_arguments import Study
from morph.app.cli.view_arguments import ViewCommand
from morph.app.cli.weigh_arguments import Weigh
from morph.errors import MorphError
from morph.extras import extra_of, install_command, require

DONE, UNUSABLE, STOPPED_SHORT, INTERRUPTED = 0, 2, 3, 130
"""Exit statuses, the same for every command."""

Command = (
    Diagnose
    | Compare
    | Excite
    | Inspect
    | Convert
    | Simulate
    | Learn
    | Loop
    | Align
    | Transfer
    | Print
    | Weigh
    | ViewCommand
    | Study
    | List
)
"""What is asked: one command with its options."""

Asked = (
    Annotated[Diagnose, tyro.conf.subcommand("diagnose")]
    | Annotated[Compare, tyro.conf.subcommand("compare")]
    | Annotated[Excite, tyro.conf.subcommand("excite")]
    | Annotated[Inspect, tyro.conf.subcommand("inspect")]
    | Annotated[Convert, tyro.conf.subcommand("convert")]
    | Annotated[Simulate, tyro.conf.subcommand("simulate")]
    | Annotated[Learn, tyro.conf.subcommand("learn")]
    | Annotated[Loop, tyro.conf.subcommand("loop")]
    | Annotated[Align, tyro.conf.subcommand("align")]
    | Annotated[Transfer, tyro.conf.subcommand("transfer")]
    | Annotated[Print, tyro.conf.subcommand("print")]
    | Annotated[Weigh, tyro.conf.subcommand("weigh")]
    | Annotated[ViewCommand, tyro.conf.subcommand("view")]
    | Annotated[Study, tyro.conf.subcommand("study")]
    | Annotated[List, tyro.conf.subcommand("list")]
)

# The name of each command, whose module and function are called after it, and the extra it needs.
_COMMANDS: dict[type, tuple[str, str | None]] = {
    Diagnose: ("diagnose", None),
    Compare: ("compare", None),
    Excite: ("excite", None),
    Inspect: ("inspect", None),
    Convert: ("convert", None),
    Simulate: ("simulate", None),
    Learn: ("learn", "learn"),
    Loop: ("loop", "learn"),
    Align: ("align", "learn"),
    Transfer: ("transfer", "learn"),
    Print: ("print", "print"),
    Weigh: ("weigh", "print"),
    ViewCommand: ("view", "view"),
    Study: ("study", None),
    List: ("list", None),
}

SUMMARY = """Compare the robot you think you have with what your robot did.

Example: morph inspect poppy.urdf

Example: morph simulate pendulum --start hinge=1 --video swing.mp4

Example: morph compare double_pendulum rig.toml

Example: morph diagnose double_pendulum rig.toml --out report

Example: morph excite double_pendulum --for-everything --out plan

Example: morph learn swing-up --robot cartpole --out learned

Example: morph loop swing-up --robot cartpole --sealed 7 --out carried

Example: morph align cartpole rider_rigid_driven

Example: morph transfer --from learned --chain cartpole rider_rigid_driven --out carried

Example: morph print so101 --printer mk4 --material pla --out package

Example: morph weigh package P-01=12.4

Example: morph view cartpole rider_rigid_driven --task balance --policy learned

Example: morph study swing.toml --workers 2 --out swing

Exit status: 0 done, 2 what was given cannot be used, 3 stopped short, 130 interrupted.
`morph --version` says which morph this is; `morph COMMAND --help` says more."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    0 done; 2 unusable input, with one message; 3 stopped short, what was found is
    written and says so; 130 interrupted.
    """
    logging.getLogger("morph").addHandler(logging.NullHandler())
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        # A name that the terminal cannot show is escaped, never an end to the work.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    given = sys.argv[1:] if argv is None else list(argv)
    if given == ["--version"]:
        sys.stdout.write(f"morph {morph.__version__}\n")
        return DONE
    try:
        status = _run(_asked(given))
        # What is still held back must fail here, not when Python has ended.
        sys.stdout.flush()
        return status
    except (MorphError, AlignError) as error:
        where, what, fix = (harmless(text) for text in (error.where, error.what, error.fix))
        sys.stderr.write(f"error: {where}: {what}\n  fix: {fix}\n")
        return UNUSABLE
    except ModuleNotFoundError as error:
        extra = extra_of(error.name or "")
        if extra is None:
            raise
        sys.stderr.write(
            f"error: {error.name} is not installed, which this needs\n"
            f"  fix: {install_command(extra)}\n"
        )
        return UNUSABLE
    except KeyboardInterrupt:
        sys.stderr.write("interrupted; nothing was written\n")
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        where = harmless(str(error.filename or "standard output"))
        if error.filename is None:
            # What is left in the buffer would fail once more at the end, with a status of its own.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stderr.write(
            f"error: {where}: {error.strerror or error}\n"
            "  fix: print it elsewhere; what a command writes is in its --out\n"
        )
        return UNUSABLE


def _open_streams() -> None:
    """Give the program an output and an error output where it was started without (`>&-`)."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 -- open to the end


def _asked(given: Sequence[str]) -> Command:
    try:
        options: Command = tyro.cli(
            Asked,
            prog="morph",
            description=SUMMARY,
            args=given,
            config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.OmitArgPrefixes),
        )
        return options
    finally:
        # Help ends the program; where nobody reads it, that must be seen before.
        sys.stdout.flush()


def _run(options: Command) -> int:
    name, extra = _COMMANDS[type(options)]
    if extra is not None:
        # Before the work: a search whose policy cannot be written would be lost.
        require(extra, f"morph {name}")
    module = import_module(f"morph.app.cli.{name}")
    status: int = getattr(module, f"run_{name}")(options)
    return status


def entry() -> None:
    """Run the command and leave with its exit status."""
    sys.exit(main())
