from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

# What a shell starts in its background ignores interrupts, and so would what it starts.
HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
MORPH = (sys.executable, "-c", HEARS + "from morph.app.cli.main import entry; entry()")


def test_the_command_serves_a_page_until_it_is_interrupted(
    look: Callable[..., Any], tmp_path: Path
) -> None:
    words = ("view", "cartpole", "pendulum", "--port", "0", "--json")
    running = subprocess.Popen(
        [*MORPH, *words],
        cwd=tmp_path,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert running.stdout is not None
        told = json.loads(running.stdout.readline())
        assert told["schema"] == "morph.viewing/1"
        person = look(told["address"])
        for name in ("cartpole", "pendulum"):
            assert name in person.text()
        running.send_signal(signal.SIGINT)
        began = time.monotonic()
        out, err = running.communicate(timeout=20.0)
    finally:
        running.kill()
    # The page is still open: nobody waits for it to close.
    assert time.monotonic() - began < 10.0
    assert running.returncode == 0
    assert out == ""
    assert "Traceback" not in err
    # A server that is gone is no fault of the page.
    person.wrong.clear()
