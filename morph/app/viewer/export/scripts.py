"""What a page with viser's client within it may do."""

from __future__ import annotations

from morph.app.viewer.front_page import allowed, script_hash, viser_program

ANY = "'unsafe-inline'"
"""What stands for the hashes where viser's client is packed otherwise than is known here. A
hash beside it would take it back."""


def policy(viser_page: str, *ours: str) -> str:
    """Return the content security policy of a page that holds viser's page and scripts of ours.

    Nothing may be loaded from anywhere, and no script may run but those that it holds. Those
    may evaluate text, as viser's client does where it binds WebAssembly.
    """
    hashes = allowed(viser_page, viser_program(viser_page))
    if hashes != (ANY,):
        hashes = (*hashes, *(script_hash(each.encode()) for each in ours))
    return (
        f"default-src 'none'; script-src {' '.join(hashes)} 'unsafe-eval'; worker-src blob:; "
        "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )
