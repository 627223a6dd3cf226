from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

# What a shell starts in its background ignores interrupts, and so would what it starts.
HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
MORPH = (sys.executable, "-c", HEARS + "from morph.app.cli.main import entry; entry()")


def test_the_command_serves_a_page_until_it_is_interrupted(
    blank: Callable[..., Any], tmp_path: Path
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
        person = blank()
        person.page.goto(told["address"])
        for name in ("cartpole", "pendulum"):
            person.until(lambda name=name: name in person.text(), f"{name} is told of")
        running.send_signal(signal.SIGINT)
        # The page is still open: who waited for it to close would wait for ever.
        out, err = running.communicate(timeout=60.0)
    finally:
        running.kill()
    assert running.returncode == 0
    assert out == ""
    assert "Traceback" not in err
    # A server that is gone is no fault of the page.
    person.wrong.clear()
