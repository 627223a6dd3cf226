"""Downloads of a page: the page as HTML and its state as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from morph.app.viewer.camera import camera_of
from morph.app.viewer.state import saved

if TYPE_CHECKING:
    from morph.app.viewer.session import Session


def keep_view(session: Session) -> None:
    """Have the browser save what is shown as JSON, which `morph view --state` shows again."""
    text = saved(session).text()
    session.client.send_file_download("morph-view.json", text.encode(), save_immediately=True)


def keep_page(session: Session) -> None:
    """Have the browser save one page that opens without a network; it takes some seconds."""
    from morph.app.viewer.export.page import exported_page

    if session.keeping:
        # Whoever presses twice wants one page, and each takes a processor for seconds.
        return
    session.keeping = True
    content, stage = session.content, session.stage
    arrows, following = set(stage.shown_arrows), stage.following
    camera, command = camera_of(session.client.camera), session.opening.command
    name, title = f"morph-{session.view.name}.html", session.view.title

    def work() -> str:
        try:
            return exported_page(
                content,
                title=title,
                command=command,
                arrows=arrows,
                following=following,
                camera=camera,
            )
        finally:
            session.keeping = False

    def done(page: str) -> None:
        session.client.send_file_download(name, page.encode(), save_immediately=True)
        session.say(f"{name} is saved: {len(page) / 1e6:.1f} MB, and opens without a network.")

    session.say("The page is being made: it takes some seconds.")
    session.later(work, done)
