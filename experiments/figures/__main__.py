"""`make figures`: write the tables of README and experiments/README from the result files."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from pathlib import Path

from experiments.figures.catalogue import CATALOGUE, PYTHON, load_catalogue
from experiments.figures.result_file import RESULTS, ROOT
from experiments.figures.tables import pages, stale_results, why_run
from morph.errors import MorphError
from morph.files import write_whole


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit status."""
    parser = argparse.ArgumentParser(prog="python -m experiments.figures", description=__doc__)
    parser.add_argument(
        "--commands", action="store_true", help="print the commands of missing and stale results"
    )
    options = parser.parse_args(arguments)
    try:
        if options.commands:
            print_commands()
        else:
            _write_pages()
        sys.stdout.flush()
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        return close_pipe()
    return 0


def print_commands(catalogue: Path = CATALOGUE, folder: Path = RESULTS) -> None:
    """Print the commands of studies whose result is missing, damaged or stale.

    Raises:
        StudyError: The catalogue cannot be used.
    """
    for study in load_catalogue(catalogue)[0]:
        if why := why_run(study, folder):
            minutes = "?" if study.minutes is None else f"{study.minutes:g}"
            print(f"{PYTHON} {study.command} --save  # {why}, {minutes} min")


def _write_pages() -> None:
    for path, text in pages().items():
        if path.read_text(encoding="utf-8") != text:
            write_whole(path, text)
            print(f"wrote {path.relative_to(ROOT)}")
    stale = set(stale_results())
    for study in load_catalogue()[0]:
        if study.name in stale:
            print(f"stale: {study.name}: {PYTHON} {study.command} --save")


def close_pipe() -> int:
    """Return the exit status of a program whose stdout was closed by its reader, such as `head`."""
    # Otherwise Python flushes its buffer into the closed pipe at exit, and prints an error.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 128 + signal.SIGPIPE


if __name__ == "__main__":
    sys.exit(main())
