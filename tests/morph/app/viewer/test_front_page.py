from __future__ import annotations

import base64
import gzip
import hashlib
import re

from morph.app.viewer.front_page import (
    DIGITS,
    THROTTLED,
    UNPACKED,
    front_page,
    unpack,
    viser_program,
)


def packed(data: bytes) -> str:
    """Pack as viser does: four bytes as five digits, what is left as one more than it has."""
    out = ""
    for at in range(0, len(data), 4):
        word = data[at : at + 4]
        value = int.from_bytes(word, "big")
        digits = [value // 88**power % 88 for power in range(len(word), -1, -1)]
        out += "".join(DIGITS[digit] for digit in digits)
    return out


def test_what_is_packed_is_unpacked_whatever_its_length() -> None:
    for length in range(13):
        data = bytes((37 * at + 200) % 256 for at in range(length))
        assert unpack(packed(data)) == data


def test_both_copies_of_the_page_are_the_same() -> None:
    page = front_page()
    assert gzip.decompress(page.packed) == page.plain


def test_the_scripts_that_stand_in_the_page_may_run_and_no_other() -> None:
    page = front_page()
    scripts = re.findall(rb"<script[^>]*>(.*?)</script>", page.plain, re.DOTALL)
    hashes = {
        f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"
        for script in scripts
    }
    # One more is allowed: the program that viser's script unpacks. A browser tells which it is.
    assert hashes < set(page.scripts)
    assert len(page.scripts) == len(hashes) + 1
    assert "'unsafe-inline'" not in page.policy("localhost:1").split("style-src")[0]


def test_the_page_may_speak_with_us_alone() -> None:
    policy = front_page().policy("localhost:8080")
    speaks = next(part for part in policy.split("; ") if part.startswith("connect-src"))
    assert speaks.split()[1:] == ["'self'", "ws://localhost:8080", "data:", "blob:"]
    assert "frame-ancestors 'none'" in policy
    assert "default-src 'none'" in policy


def test_the_installed_viser_is_one_whose_lost_inputs_are_mended() -> None:
    # That inputs come through is seen in a browser; where viser changes, this says what to look at.
    page = front_page().plain.decode()
    program = viser_program(page)
    assert program is not None
    assert len(THROTTLED.findall(program)) == 1
    assert page.count(f"{UNPACKED}.replace(") == 1
