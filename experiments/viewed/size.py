"""How large exported pages are."""

from __future__ import annotations

import subprocess
import tempfile
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from experiments.viewed.browser import free_port
from experiments.viewed.served import COMMAND
from morph.arrays import JSON
from morph.errors import OutputError


def exported(words: str) -> JSON:
    """Return how large the page is that `morph view --html` writes of a comparison, MB (1e6 bytes).

    Args:
        words: What the command is told besides.

    Raises:
        OutputError: The command writes nothing.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        told = [*words.split(), "--first", "compare", "--html", str(file), "--quiet"]
        ran = subprocess.run([*COMMAND, *told], capture_output=True, text=True, check=False)
        if ran.returncode or not file.is_file():
            raise OutputError(
                f"exit status {ran.returncode}: {ran.stderr.strip()}",
                where=f"morph view {' '.join(told)}",
                fix="give the command by hand",
            )
        return {"words": words, "mb": 1e-6 * file.stat().st_size}


def empty_export() -> int:
    """Return the bytes of a page that viser exports by itself with nothing to show."""
    from viser import ViserServer

    with redirect_stdout(StringIO()):
        server = ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
        try:
            return len(server.scene.as_html().encode())
        finally:
            server.stop()
