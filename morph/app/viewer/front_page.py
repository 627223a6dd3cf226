"""The one page that is served: viser's, with a script of ours, and what it is allowed to do."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

DIGITS = "!#$%()*+,-./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_abcdefghijklmnopqrstuvwxyz{|}~"
"""The 88 digits that viser packs its program with: five of them for four bytes."""

SCRIPT = re.compile(r"<script\b([^>]*)>(.*?)</script>", re.DOTALL)
"""A script that stands in the page."""

PACKED = re.compile(r'data-p="([^"]*)" data-ss="(\d+)" data-cs="(\d+)"')
"""viser's program: packed, with the lengths of its style sheet and of its code."""

THROTTLED = re.compile(
    r"(?P<ready>(?P<sender>[\w$]+)\.sendMessage!==null&&)"
    r"(?P<keep>\((?P<last>[\w$]+)=(?P<input>[\w$]+),[\w$]+\?"
    r"\((?P=sender)\.sendMessage\((?P=input)\),(?P<waits>[\w$]+)=!1,)"
)
"""Where viser's program sends at most one input in 50 ms, of all widgets together, and keeps the
last of those that come between."""

UNPACKED = "td.decode(heap.subarray(up+ss,up+sz))"
"""Where viser's page has unpacked its program."""


@dataclass(frozen=True, kw_only=True)
class FrontPage:
    """What is answered to who may come in."""

    plain: bytes
    """The page."""
    packed: bytes
    """The same for browsers that take gzip."""
    scripts: tuple[str, ...]
    """What CSP calls the scripts that may run."""

    def policy(self, host: str) -> str:
        """Return what the page may do, as CSP has it; it may speak with nobody but us.

        A name from a file that became HTML in spite of all could still run nothing: only the
        scripts of the page run. Those may evaluate text, as viser's sorting program does.

        Args:
            host: What the browser calls us, with the port.
        """
        return "; ".join(
            (
                "default-src 'none'",
                f"script-src {' '.join(self.scripts)} 'unsafe-eval'",
                "style-src 'unsafe-inline'",
                "img-src data: blob:",
                "font-src data:",
                "worker-src blob:",
                # Not every browser holds a websocket to be of the same origin as its page.
                f"connect-src 'self' ws://{host} data: blob:",
                "base-uri 'none'",
                "form-action 'none'",
                "frame-ancestors 'none'",
            )
        )


def page_script() -> str:
    """Return our script for the page; empty if there is none."""
    path = Path(__file__).with_name("page.js")
    return path.read_text(encoding="utf-8") if path.is_file() else ""


@cache
def front_page() -> FrontPage:
    """Return viser's page with our script in it."""
    import viser

    path = Path(viser.__file__).parent / "client" / "build" / "index.html"
    text = path.read_text(encoding="utf-8").replace("<title>Viser</title>", "<title>morph</title>")
    text, program = _lossless(text)
    script = page_script()
    if script:
        # What ends a script must not stand inside one.
        script = script.replace("</", "<\\/")
        text = text.replace("</head>", f"<script>{script}</script></head>")
    plain = text.encode()
    return FrontPage(plain=plain, packed=gzip.compress(plain, 6), scripts=allowed(text, program))


def allowed(text: str, program: str | None) -> tuple[str, ...]:
    """Return the hashes of the page's scripts, and of the program that the first one unpacks."""
    if program is None:
        # Another viser than we know: it may run what it brings, as it does without us.
        return ("'unsafe-inline'",)
    hashes = [script_hash(body.encode()) for _, body in SCRIPT.findall(text)]
    return (*hashes, script_hash(program.encode()))


def viser_program(text: str) -> str | None:
    """Return the program that viser's page unpacks; None if it is packed in a way unknown here."""
    packed = PACKED.search(text)
    if packed is None:
        return None
    import zstandard

    styles, code = int(packed[2]), int(packed[3])
    unpacked = zstandard.ZstdDecompressor().decompress(
        unpack(packed[1]), max_output_size=styles + code
    )
    return unpacked[styles:].decode()


def _lossless(text: str) -> tuple[str, str | None]:
    """Return viser's page such that no input is lost, and the program that it runs then.

    Of several inputs within 50 ms viser 1.1 sends the first and the last, even where those
    between were of other widgets: a number typed between two movements of the pointer is seen on
    the page and never sent. Here what waits is sent as soon as another widget has something.
    """
    program = viser_program(text)
    result = None if program is None else THROTTLED.search(program)
    if program is None or result is None or text.count(UNPACKED) != 1:
        return text, program
    sender, last, now = result["sender"], result["last"], result["input"]
    flush = f"{result['waits']}&&{last}.uuid!=={now}.uuid&&{sender}.sendMessage({last}),"
    mended = f"{result['ready']}({flush}{result['keep'][1:]}"
    mend = f".replace({json.dumps(result[0])},()=>{json.dumps(mended)})"
    return text.replace(UNPACKED, UNPACKED + mend), program.replace(result[0], mended, 1)


def unpack(text: str) -> bytes:
    """Return the bytes of a text in viser's 88 digits; what is left of five is shorter."""
    digits = np.zeros(127, dtype=np.uint64)
    for value, digit in enumerate(DIGITS):
        digits[ord(digit)] = value
    values = digits[np.frombuffer(text.encode("ascii"), dtype=np.uint8)]
    whole, left = divmod(len(values), 5)
    powers = np.array([88**power for power in range(4, -1, -1)], dtype=np.uint64)
    words = values[: 5 * whole].reshape(whole, 5) @ powers
    last = 0
    for value in values[5 * whole :]:
        last = 88 * last + int(value)
    return words.astype(">u4").tobytes() + last.to_bytes(8, "big")[8 - max(left - 1, 0) :]


def script_hash(script: bytes) -> str:
    """Return a script's SHA-256 as CSP has it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"
