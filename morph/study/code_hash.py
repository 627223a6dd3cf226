"""Hash of the source code that a function depends on, found by following imports."""

from __future__ import annotations

import ast
import importlib.util
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from morph.errors import StudyError
from morph.files import sha256

NATIVE = ("*.c", "*.h")
"""Sources in C, which are hashed with the modules of their folder."""

RUNNERS = ("morph.study",)
"""Packages left out of the hash: they decide where a cell runs, not what it returns."""

LOADERS = ("import_module", "__import__", "resolve_name", "run_module", "spec_from_file_location")
"""Functions that load a module by its name. In a file that mentions one, under whatever alias,
every string that names a project module counts as an import."""

Roots = tuple[Path, ...]


def code_hash(module: str, *, path: Iterable[Path] = (), ignore: tuple[str, ...] = RUNNERS) -> str:
    """Return a SHA-256 over the source of a module and of every project module it imports.

    The project is the folder that holds the module's top-level package, and the folders of
    `path`; what is installed elsewhere is not followed. Imports inside functions count, imports
    for type checkers do not. A string that names a project module
    (`"morph.search.cmaes:CmaEs"`) counts as an import, also one without a dot (`"cmaes"`) in a
    file that loads modules by name (`LOADERS`). A computed name and executed text cannot be
    followed.

    Args:
        module: Dotted name, importable from here.
        path: Folders put before `sys.path`.
        ignore: Packages and modules that are neither hashed nor followed, with their submodules,
            since no row depends on them: they run cells, show progress and write results.
            Otherwise a better message of the engine would make every result stale. An entry that
            contains `module` itself has no effect.

    Raises:
        StudyError: There is no such module, or it has no source.
    """
    return _hash(module, _roots(module, path), _ignored(module, ignore))


def sources(
    module: str, *, path: Iterable[Path] = (), ignore: tuple[str, ...] = RUNNERS
) -> tuple[Path, ...]:
    """Return the files that `code_hash` hashes, sorted by module.

    Raises:
        StudyError: There is no such module, or it has no source.
    """
    return tuple(
        file for _, file in _closure(module, _roots(module, path), _ignored(module, ignore))
    )


def source_folder(module: str) -> Path:
    """Return the folder that holds a module's top-level package or file.

    Raises:
        StudyError: There is no such module, or it has no source.
    """
    top = module.partition(".")[0]
    try:
        spec = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        spec = None
    if spec is None:
        raise StudyError(
            f"there is no module {module!r}",
            where="morph.study",
            fix="name an importable module; run from the folder that holds it",
        )
    if spec.submodule_search_locations:
        return Path(next(iter(spec.submodule_search_locations))).resolve().parent
    if spec.origin and spec.origin.endswith(".py"):
        return Path(spec.origin).resolve().parent
    raise StudyError(
        f"module {module!r} has no Python source, so its code cannot be hashed",
        where="morph.study",
        fix="give a function that is defined in a .py file",
    )


def _roots(module: str, path: Iterable[Path]) -> Roots:
    """Return the folders of the project, in the order in which Python looks there."""
    return tuple(dict.fromkeys((*(each.resolve() for each in path), source_folder(module))))


def _ignored(module: str, ignore: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(each for each in ignore if not _inside(module, (each,)))


def _inside(module: str, packages: tuple[str, ...]) -> bool:
    return any(f"{module}.".startswith(f"{each}.") for each in packages)


@cache
def _hash(module: str, roots: Roots, ignore: tuple[str, ...]) -> str:
    parts: list[str | bytes] = []
    for name, file in _closure(module, roots, ignore):
        parts += [f"{name}\n", file.read_bytes()]
    return sha256(*parts)


@cache
def _closure(module: str, roots: Roots, ignore: tuple[str, ...]) -> tuple[tuple[str, Path], ...]:
    """Return the source files with the names of their modules, sorted by name.

    In packages above an imported module, strings are not followed as imports.
    """
    if _file(module, roots) is None:
        raise StudyError(
            f"module {module!r} has no source below {roots[-1]}",
            where="morph.study",
            fix="give a function that is defined in a .py file",
        )
    waiting, met, seen = [(module, True)], set[tuple[str, bool]](), dict[str, Path]()
    while waiting:
        name, whole = waiting.pop()
        # Most names are met many times, and a look for a file takes longer than all else here.
        if (name, whole) in met or (name, True) in met:
            continue
        met.add((name, whole))
        file = None if _inside(name, ignore) else seen.get(name) or _file(name, roots)
        if file is None:
            continue
        seen[name] = file
        parent = name.rpartition(".")[0]
        if parent:
            # Importing a module runs its parent packages, but not their lazy imports by name.
            waiting.append((parent, False))
        result = _imports(name, file, roots)
        waiting += [(each, True) for each, string in result if whole or not string]
    named, folders = {file: name for name, file in seen.items()}, dict[Path, str]()
    for name, file in seen.items():
        folders.setdefault(file.parent, name.rpartition(".")[0])
    for folder, package in folders.items():
        for native in (each for kind in NATIVE for each in folder.glob(kind)):
            named.setdefault(native, f"{package}/{native.name}")
    return tuple(sorted((name, file) for file, name in named.items()))


def _file(name: str, roots: Roots) -> Path | None:
    """Return the source of a project module, None for what is not the project's."""
    stems = [root.joinpath(*name.split(".")) for root in roots]
    files = (file for stem in stems for file in (stem / "__init__.py", stem.with_suffix(".py")))
    return next((file for file in files if file.is_file()), None)


@cache
def _imports(name: str, file: Path, roots: Roots) -> tuple[tuple[str, bool], ...]:
    """Return the project modules that one module names, and whether by no more than a string."""
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    source = file.read_bytes()
    try:
        nodes = tuple(_executable(ast.parse(source, filename=str(file))))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        # Python cannot import it either: `try: import old` / `except SyntaxError` may use another.
        return ()
    names = _lazy(file, package)
    strings = set(range(len(names)))
    # Few files hold such a word at all: only there every node is looked at.
    words = any(each.encode() in source for each in (*LOADERS, "importlib"))
    by_name = words and any(map(_mentions_loader, nodes))
    for node in nodes:
        if isinstance(node, ast.Import):
            names += [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            origin = _absolute("." * node.level + (node.module or ""), package)
            submodules = {n.name for n in node.names if _file(f"{origin}.{n.name}", roots)}
            names += [f"{origin}.{each}" for each in sorted(submodules)]
            if len(submodules) < len(node.names):
                names.append(origin)
        elif isinstance(node, ast.Call):
            names += [_absolute(each, package) for each in _loaded(node)]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value.partition(":")[0]
            bare = text.lstrip(".") if by_name else text
            if (by_name or "." in text) and all(part.isidentifier() for part in bare.split(".")):
                strings.add(len(names))
                names.append(_absolute(text, package))
    return tuple((each, at in strings) for at, each in enumerate(names))


def _lazy(file: Path, package: str) -> list[str]:
    """Return the modules whose names a package gives on first use, by the stub beside it."""
    stub = file.with_suffix(".pyi")
    if not stub.is_file():
        return []
    nodes = ast.walk(ast.parse(stub.read_bytes(), filename=str(stub)))
    return [
        _absolute("." * node.level + (node.module or ""), package)
        for node in nodes
        if isinstance(node, ast.ImportFrom)
    ]


def _absolute(name: str, package: str) -> str:
    """Return a name without its leading dots, which count packages from this one upwards."""
    bare = name.lstrip(".")
    level = len(name) - len(bare)
    above = package.rsplit(".", level - 1)[0] if level else ""
    return ".".join(filter(None, (above, bare)))


def _mentions_loader(node: ast.AST) -> bool:
    """Return whether a node names one of `LOADERS`, or imports all that importlib has."""
    if isinstance(node, ast.ImportFrom) and node.module == "importlib":
        return any(each.name in (*LOADERS, "*") for each in node.names)
    named = [getattr(node, part, None) for part in ("id", "attr", "name", "value")]
    return any(each in LOADERS for each in named if isinstance(each, str))


def _loaded(call: ast.Call) -> list[str]:
    """Return the module that a call such as `import_module("cmaes")` imports."""
    function = call.func.attr if isinstance(call.func, ast.Attribute) else call.func
    name = function.id if isinstance(function, ast.Name) else function
    values = [*call.args[:1], *(each.value for each in call.keywords if each.arg == "name")]
    constants = [each.value for each in values if isinstance(each, ast.Constant)]
    return [each for each in constants if isinstance(each, str)] if name in LOADERS else []


def _executable(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield every node but those below `if TYPE_CHECKING`."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.If) and _for_type_checkers(node.test):
            waiting += node.orelse
        else:
            waiting += ast.iter_child_nodes(node)


def _for_type_checkers(test: ast.expr) -> bool:
    """Return whether a test is `TYPE_CHECKING` or `typing.TYPE_CHECKING`, and nothing more."""
    if isinstance(test, ast.Attribute):
        owner = test.value.id if isinstance(test.value, ast.Name) else None
        return (owner, test.attr) == ("typing", "TYPE_CHECKING")
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"
