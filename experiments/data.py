"""`python -m experiments.data`: fetch, verify and list the public data of studies and tests."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from experiments.figures.__main__ import close_pipe
from experiments.public.audit import audit, write_manifest
from experiments.public.content import DataError as DataError
from experiments.public.download import install
from experiments.public.manifest import FETCHED, VARIABLES, DataSet, Hosts, load_sets
from experiments.public.manifest import data_root as data_root
from morph.errors import MorphError

DEFAULT_FOLDERS = "the folders that studies read"
"""Value of --check without a folder."""
EXAMPLE = """examples:
  .venv/bin/python -m experiments.data --list
  .venv/bin/python -m experiments.data --set poppy_humanoid
  .venv/bin/python -m experiments.data --check ../shared
"""
MAX_FAILURES = 3
"""Failed files of a set after which the rest of it is not tried."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status: 0, 1 where files are amiss, 2 for an error."""
    try:
        status = _run(arguments)
        sys.stdout.flush()
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        return close_pipe()
    except KeyboardInterrupt:
        return 130
    return status


def _run(arguments: Sequence[str] | None) -> int:
    sets = load_sets()
    options = _parser([data_set.name for data_set in sets]).parse_args(arguments)
    chosen = [data_set for data_set in sets if options.set in (None, data_set.name)]
    if options.list:
        return _list(chosen)
    if options.where:
        print(data_root(chosen[0].kind) / options.set if options.set else data_root())
        return 0
    if options.check is not None:
        return _check(chosen, None if options.check == DEFAULT_FOLDERS else Path(options.check))
    if options.write_manifest is not None:
        for data_set in chosen:
            print(write_manifest(options.write_manifest, data_set))
        return 0
    hosts = (
        Hosts(raw=options.mirror, media=f"{options.mirror}/media") if options.mirror else Hosts()
    )
    return _fetch(chosen, options.to, hosts)


def _parser(names: list[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.data",
        description="Fetch, verify and list the public data that studies and tests read.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--set",
        choices=names,
        metavar="NAME",
        help="only this set, a name of --list (default: all)",
    )
    parser.add_argument(
        "--to",
        type=Path,
        default=FETCHED,
        metavar="DIR",
        help="folder to fetch into (default: experiments/data)",
    )
    parser.add_argument(
        "--mirror",
        metavar="URL",
        help="server with files under OWNER/NAME/COMMIT/PATH (default: GitHub)",
    )
    one = parser.add_mutually_exclusive_group()
    one.add_argument("--list", action="store_true", help="show every set, its origin and licence")
    one.add_argument("--where", action="store_true", help="print the folder that studies read")
    one.add_argument(
        "--check",
        nargs="?",
        const=DEFAULT_FOLDERS,
        metavar="DIR",
        help="fetch nothing; say what of DIR is missing, different or unlisted "
        "(default: the folders that studies read)",
    )
    one.add_argument(
        "--write-manifest", type=Path, metavar="DIR", help="write manifests of the files in DIR"
    )
    return parser


def _list(sets: Sequence[DataSet]) -> int:
    for data_set in sets:
        megabytes = sum(public.size for public in data_set.files) / 1e6
        folder = data_root(data_set.kind) / data_set.name
        print(f"{data_set.name}: {data_set.about}")
        print(
            f"  {data_set.kind}, {len(data_set.files)} files, {megabytes:.1f} MB; "
            f"{data_set.licence}"
        )
        origins = [
            *data_set.origins,
            *(made.origin for made in data_set.made if made.origin.repository),
        ]
        for origin in dict.fromkeys(f"{one}, {one.folder or 'its root'}" for one in origins):
            print(f"  from {origin}")
        if data_set.unsettled:
            print(f"  not established: {data_set.unsettled}")
        print(f"  {folder}" if folder.is_dir() else f"  not here: --set {data_set.name} fetches it")
    return 0


def _check(sets: Sequence[DataSet], root: Path | None) -> int:
    """Print missing, different and unlisted files of a folder, and return the status."""
    status = 0
    for kind in VARIABLES:
        some = [data_set for data_set in sets if data_set.kind == kind]
        if not some:
            continue
        folder = data_root(kind) if root is None else root
        report = audit(folder, some)
        for state in ("missing", "different", "unlisted"):
            for name in getattr(report, state):
                print(f"{state}: {printable(name)}")
        print(
            f"{kind} under {printable(str(folder))}: {report.right} files as they were used, "
            f"{len(report.missing)} missing, {len(report.different)} different, "
            f"{len(report.unlisted)} unlisted"
        )
        status = status if report.whole else 1
    return status


def printable(name: str) -> str:
    """Return a name with unprintable characters, such as terminal codes, as escapes."""
    return "".join(
        each if each.isprintable() else each.encode("unicode_escape", "backslashreplace").decode()
        for each in name
    )


def _fetch(sets: Sequence[DataSet], root: Path, hosts: Hosts) -> int:
    """Fetch sets and return the status; a file that fails does not stop the others."""
    incomplete = []
    for data_set in sets:
        new = present = failed = 0
        for public in data_set.files:
            try:
                fresh = install(data_set, public, root, hosts=hosts)
                new, present = new + fresh, present + (not fresh)
            except MorphError as error:
                failed += 1
                print(f"{data_set.name}/{public.file}: {error}", file=sys.stderr)
                if failed == MAX_FAILURES:
                    print(f"{data_set.name}: {failed} files failed, given up", file=sys.stderr)
                    break
            if sys.stderr.isatty():
                sys.stderr.write(f"\r\033[K{new + present}/{len(data_set.files)} {public.file}\r")
        print(
            f"{data_set.folder(root)}: {new} of {len(data_set.files)} files fetched, "
            f"{present} were there"
        )
        if data_set.licence.startswith("none"):
            print("  its publisher states no licence: do not pass it on")
        if failed:
            incomplete.append(data_set.name)
    if incomplete:
        print(f"not complete: {', '.join(incomplete)}; run it again to go on", file=sys.stderr)
    return 2 if incomplete else 0


if __name__ == "__main__":
    sys.exit(main())
