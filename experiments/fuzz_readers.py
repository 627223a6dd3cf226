"""Fuzzing of everything that reads files from strangers: any file gives a result or a MorphError.

    python -m experiments.fuzz_readers urdf --seconds 3600

`all` shares the time among the targets. Bytes are guided by which lines of morph they reach
(atheris, libFuzzer); XML is also spoiled by its structure. What crashes, hangs or ends the
process is written to the folder of `--out`, one file for each place in the code.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments import fuzz_seeds as seeds
from experiments.fuzz_seeds import spoil

MORPH = Path(__file__).resolve().parents[1] / "morph"
"""The source of the package whose readers are fuzzed."""

SLOWEST = 20
"""Seconds for one file, on a machine that does other things too, after which it counts as hung."""

MEMORY_MB = 3000
"""Memory of a process; the libraries alone take a third."""

LONGEST = 8192
"""Bytes in a file that is made."""

FEW = 1000
"""Files of which each is counted at once; of more the count is kept once a second."""

MODULE = ("-m", "experiments.fuzz_readers")
"""How Python finds this file in a new process."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """A reader to be fuzzed."""

    ending: str
    """The ending of its files; a whole name if it starts with no dot."""
    seed: Callable[[], bytes]
    """A valid file."""
    reader: Callable[[], Callable[[Path], Any]]
    """Imports the reader and returns it."""
    tree: bool = False
    """Whether its files are XML, to be spoiled by structure."""


def _robot() -> Callable[[Path], Any]:
    from morph.body.load import load

    return load


def _card() -> Callable[[Path], Any]:
    from morph.body.card import load_card

    return load_card


def _xacro() -> Callable[[Path], Any]:
    # Here and not in a process of its own, so that the fuzzer sees which lines are reached.
    from morph.body.xacro.check import check
    from morph.body.xacro.folder import Folder
    from morph.body.xacro.macros import expand

    def read(path: Path) -> object:
        check(path, Folder(path.parent), {})
        return expand(path, path.parent, {}, 5000)

    return read


def _mesh() -> Callable[[Path], Any]:
    from morph.body.mesh import read_mesh

    return lambda path: read_mesh(path.read_bytes(), path.suffix, str(path))


def _recording() -> Callable[[Path], Any]:
    from morph.record.load import load_recordings

    return load_recordings


TARGETS = {
    "urdf": Target(ending=".urdf", seed=lambda: seeds.URDF, reader=_robot, tree=True),
    "mjcf": Target(ending=".xml", seed=lambda: seeds.MJCF, reader=_robot, tree=True),
    "xacro": Target(ending=".xacro", seed=lambda: seeds.XACRO, reader=_xacro, tree=True),
    "assembly": Target(ending=".toml", seed=lambda: seeds.ASSEMBLY, reader=_robot),
    "card": Target(ending="card.toml", seed=lambda: seeds.CARD, reader=_card),
    "stl": Target(ending=".stl", seed=seeds.stl, reader=_mesh),
    "obj": Target(ending=".obj", seed=lambda: seeds.OBJ, reader=_mesh),
    "ply": Target(ending=".ply", seed=lambda: seeds.PLY, reader=_mesh),
    "3mf": Target(ending=".3mf", seed=seeds.threemf, reader=_mesh),
    "dae": Target(ending=".dae", seed=lambda: seeds.COLLADA, reader=_mesh, tree=True),
    "csv": Target(ending=".csv", seed=lambda: seeds.CSV, reader=_recording),
    "npz": Target(ending=".npz", seed=lambda: seeds.recorded(".npz"), reader=_recording),
    "parquet": Target(
        ending=".parquet", seed=lambda: seeds.recorded(".parquet"), reader=_recording
    ),
    "h5": Target(ending=".h5", seed=lambda: seeds.recorded(".h5"), reader=_recording),
}


def fuzz(name: str, folder: Path, seconds: int, files: int, seed: int) -> None:
    """Fuzz one target in this process, which ends with it; `folder` gets what is found.

    Args:
        name: The target.
        folder: Where its file is written, and what is found.
        seconds: After so many it ends.
        files: After so many it ends; -1 for any number.
        seed: Random seed.
    """
    import atheris  # type: ignore[import-untyped]

    target, whole = TARGETS[name], TARGETS[name].seed()
    path = placed(target, folder)
    with atheris.instrument_imports(include=["morph"]):
        from morph.errors import MorphError

        read = target.reader()
        # Much is imported when first needed; what is imported later is not seen.
        read(path)
    tally = _Tally(folder)

    def one(content: bytes) -> None:
        path.write_bytes(content)
        try:
            read(path)
            tally.add("read")
        except MorphError:
            tally.add("refused")
        except Exception as error:
            tally.crash(error, content)

    def mutated(content: bytes, longest: int, seed: int) -> bytes:
        rng = random.Random(seed)
        if target.tree and rng.random() < 0.7:
            # What is no tree any more leads nowhere: begin again.
            for source in (content, whole):
                with contextlib.suppress(ElementTree.ParseError, ValueError):
                    changed = spoil(source, rng)
                    if len(changed) <= longest:
                        return changed
        return bytes(atheris.Mutate(content, longest))

    corpus = folder / "corpus"
    corpus.mkdir(exist_ok=True)
    (corpus / "seed").write_bytes(whole)
    options = [f"-max_total_time={seconds}", f"-timeout={SLOWEST}", f"-rss_limit_mb={MEMORY_MB}"]
    # By default libFuzzer begins with short files, and cuts ours to fit.
    options += [
        "-len_control=0",
        f"-runs={files}",
        f"-max_len={LONGEST}",
        f"-artifact_prefix={folder}/ended-",
        f"-seed={seed}",
    ]
    atheris.Setup([name, *options, str(corpus)], one, custom_mutator=mutated)
    atheris.Fuzz()


def placed(target: Target, folder: Path) -> Path:
    """Return a target's valid file in a folder of its own, with the mesh that it may name."""
    own = folder / "own"
    own.mkdir(exist_ok=True)
    (own / "part.stl").write_bytes(seeds.stl())
    path = own / (f"file{target.ending}" if target.ending.startswith(".") else target.ending)
    path.write_bytes(target.seed())
    return path


def place_in(package: Path, error: BaseException) -> str:
    """Return the file and line of a package that an error went through last, or `nowhere`."""
    frames = traceback.extract_tb(error.__traceback__)
    inside = [each for each in frames if Path(each.filename).resolve().is_relative_to(package)]
    return f"{Path(inside[-1].filename).stem}_{inside[-1].lineno}" if inside else "nowhere"


class _Tally:
    """Counts files, and keeps the first that crashes at each place."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.written = folder, 0.0
        self.counts = {"read": 0, "refused": 0, "crashed": 0}
        with contextlib.suppress(OSError, ValueError):
            self.counts |= json.loads((folder / "counts.json").read_text())

    def add(self, what: str) -> None:
        self.counts[what] += 1
        # libFuzzer ends the process without a word, so the count is kept beside it.
        if sum(self.counts.values()) <= FEW or time.monotonic() > self.written + 1.0:
            self.written = time.monotonic()
            (self.folder / "counts.json").write_text(json.dumps(self.counts))

    def crash(self, error: Exception, content: bytes) -> None:
        self.add("crashed")
        place = place_in(MORPH, error)
        kept = self.folder / f"crash-{type(error).__name__}-{place}"
        if not kept.exists() or kept.stat().st_size > len(content):
            kept.write_bytes(content)
            said = "".join(traceback.format_exception(error))
            kept.with_name(f"{kept.name}.txt").write_text(said[-5000:])


def run(name: str, seconds: float, out: Path, seed: int = 1, *, files: int = -1) -> dict[str, Any]:
    """Return what fuzzing a target found; its process is begun anew if it ends.

    Args:
        name: The target.
        seconds: How long it is fuzzed.
        out: Folder of the files that crash it.
        seed: Random seed.
        files: Number of files after which it is enough; -1 for any.
    """
    end, enough = time.monotonic() + seconds, False
    found: list[str] = []
    with tempfile.TemporaryDirectory(prefix="fuzz_") as temporary:
        folder = Path(temporary)
        while not enough and (left := int(end - time.monotonic())) > 0:
            told = ["--child", temporary, "--seconds", str(left), "--seed", str(seed)]
            told += ["--files", str(files)]
            with (folder / "log").open("ab") as log:
                ran = subprocess.run(
                    [sys.executable, *MODULE, name, *told],
                    # MuJoCo writes its log where it stands.
                    cwd=folder,
                    env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[1])},
                    stdout=subprocess.DEVNULL,
                    stderr=log,
                    check=False,
                )
            seed, enough = seed + 1, files >= 0 and ran.returncode == 0
        for path in sorted([*folder.glob("crash-*"), *folder.glob("ended-*")]):
            out.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, out / f"{name}-{path.name}")
            found += [] if path.suffix == ".txt" else [f"{name}-{path.name}"]
        with contextlib.suppress(OSError, ValueError):
            counts = json.loads((folder / "counts.json").read_text())
            return {"target": name, **counts, "found": found}
        return {"target": name, "said": (folder / "log").read_text()[-2000:], "found": found}


def main(arguments: list[str] | None = None) -> int:
    """Fuzz one reader or all, print what was found; 0 if nothing was."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("target", choices=[*TARGETS, "all"])
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"), help="for what crashes")
    parser.add_argument("--files", type=int, default=-1, help="end after so many")
    parser.add_argument("--child", type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args(arguments)
    if chosen.child is not None:
        fuzz(chosen.target, chosen.child, chosen.seconds, chosen.files, chosen.seed)
        return 0
    names = list(TARGETS) if chosen.target == "all" else [chosen.target]
    bad = False
    for name in names:
        result = run(name, chosen.seconds / len(names), chosen.out, chosen.seed, files=chosen.files)
        bad |= bool(result["found"]) or "read" not in result
        print(json.dumps(result), flush=True)
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
