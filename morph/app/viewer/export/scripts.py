"""Which scripts a page with viser's client may run: those it holds, by their hashes."""

from __future__ import annotations

import base64
import hashlib
import re

SCRIPT = re.compile(r"<script([^>]*)>(.*?)</script>", re.DOTALL)
"""A script in viser's page; it has none that holds `>` in what is before its text but one."""

PACKED = re.compile(r'<script data-p="([^"]*)" data-ss="(\d+)" data-cs="(\d+)">')
"""Its client, packed: the first bytes are styles, the others the program."""

DIGITS = "".join(chr(each) for each in range(0x21, 0x7F) if chr(each) not in "\"&<>'`")
"""The 88 digits in which it is packed; five of them are four bytes."""


def policy(viser_page: str, *ours: str) -> str:
    """Return the content security policy of a page that holds viser's page and scripts of ours.

    Nothing may be loaded from anywhere, and no script may run but these.
    """
    scripts = [*(match[2] for match in SCRIPT.finditer(viser_page)), *ours]
    program = _program(viser_page)
    allowed = (
        " ".join(_hash(script) for script in [*scripts, program])
        if program is not None
        # A client that is packed otherwise could not run; without a network it can do no harm.
        else "'unsafe-inline'"
    )
    # viser's client makes functions of text where it binds WebAssembly.
    return (
        f"default-src 'none'; script-src {allowed} 'unsafe-eval' blob:; worker-src blob:; "
        "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )


def _program(viser_page: str) -> str | None:
    """Return the text of viser's client, which its page unpacks and runs; None if not found."""
    import zstandard

    found = PACKED.search(viser_page)
    if found is None:
        return None
    try:
        whole = zstandard.ZstdDecompressor().decompress(
            unpacked(found[1]), max_output_size=int(found[2]) + int(found[3])
        )
        return whole[int(found[2]) :].decode()
    except (ValueError, KeyError, zstandard.ZstdError):
        return None


def unpacked(text: str) -> bytes:
    """Return the bytes that were written in base 88, five digits for four of them."""
    import numpy as np

    places = np.zeros(127, dtype=np.uint64)
    places[[ord(digit) for digit in DIGITS]] = np.arange(len(DIGITS))
    digits = places[np.frombuffer(text.encode("ascii"), dtype=np.uint8)]
    whole, last = np.split(digits, [len(digits) // 5 * 5])
    powers = np.array([len(DIGITS) ** at for at in (4, 3, 2, 1, 0)], dtype=np.uint64)
    values = whole.reshape(-1, 5) @ powers
    rest = sum(int(digit) * len(DIGITS) ** at for at, digit in enumerate(last[::-1]))
    return values.astype(">u4").tobytes() + rest.to_bytes(max(len(last) - 1, 0), "big")


def _hash(script: str) -> str:
    """Return a script's SHA-256 as a content security policy spells it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
