"""The command `morph`: what it is asked, what it answers, and its exit status."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from io import TextIOWrapper
from typing import Annotated

import tyro

from morph.app.cli.arguments import Convert, Diagnose, Inspect, List
from morph.errors import MorphError

DONE, UNUSABLE, STOPPED_SHORT, INTERRUPTED = 0, 2, 3, 130
"""Exit statuses, the same for every command."""

Asked = (
    Annotated[Diagnose, tyro.conf.subcommand("diagnose")]
    | Annotated[Inspect, tyro.conf.subcommand("inspect")]
    | Annotated[Convert, tyro.conf.subcommand("convert")]
    | Annotated[List, tyro.conf.subcommand("list")]
)

SUMMARY = """Compare the robot you think you have with what your robot did.

Example: morph inspect poppy.urdf
Example: morph diagnose double_pendulum rig.toml --out report"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    0 done; 2 unusable input, with one message; 3 stopped short, what was found is
    written and says so; 130 interrupted.
    """
    logging.getLogger("morph").addHandler(logging.NullHandler())
    for stream in (sys.stdout, sys.stderr):
        # A name that the terminal cannot show is escaped, never an end to the work.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    asked: Diagnose | Inspect | Convert | List = tyro.cli(
        Asked,
        prog="morph",
        description=SUMMARY,
        args=argv,
        config=(tyro.conf.OmitSubcommandPrefixes, tyro.conf.OmitArgPrefixes),
    )
    try:
        return _run(asked)
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return UNUSABLE
    except KeyboardInterrupt:
        sys.stderr.write("interrupted; nothing was written\n")
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        sys.stderr.write(
            f"error: standard output: {error.strerror or error}\n"
            "  fix: what was found is in --out; print it elsewhere\n"
        )
        return UNUSABLE


def _run(asked: Diagnose | Inspect | Convert | List) -> int:
    if isinstance(asked, List):
        from morph.app.cli.list import run_list

        return run_list(asked)
    if isinstance(asked, Inspect):
        from morph.app.cli.inspect import run_inspect

        return run_inspect(asked)
    if isinstance(asked, Convert):
        from morph.app.cli.convert import run_convert

        return run_convert(asked)
    from morph.app.cli.diagnose import run_diagnose

    return run_diagnose(asked)


def entry() -> None:
    """Run the command and leave with its exit status."""
    sys.exit(main())
