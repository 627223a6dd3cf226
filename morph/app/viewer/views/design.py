"""Design: joints and parameters of one body under a designer's hand."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from morph.app.viewer.content import Content
from morph.app.viewer.design.design_stage import Shown
from morph.app.viewer.design.design_state import Bench, BodyPlan, Built
from morph.app.viewer.design.figures import figures, headline, limits_note, motors
from morph.app.viewer.design.latest_work import Latest
from morph.app.viewer.design.panel import DesignPanel
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.arrays import JSON

if TYPE_CHECKING:
    from morph.app.viewer.session import Session


class DesignView(View):
    """One body at a time whose joints and parameters are moved by sliders.

    Args:
        plans: The bodies that may be designed, shared by all persons.
        seed: Of random poses.
    """

    name: ClassVar[str] = "design"
    title: ClassVar[str] = "Design"

    def __init__(self, plans: Sequence[BodyPlan], seed: int = 0) -> None:
        """Begin with the first body as it is described."""
        self.plans, self.at, self.ghost = tuple(plans), 0, True
        self._benches: dict[int, Bench] = {}
        self._rng = np.random.default_rng(seed)
        self._session: Session | None = None
        self._panel: DesignPanel | None = None
        self._building, self._measuring = Latest(), Latest()
        self._shown = Shown(self.bench, self.ghost)

    @property
    def bench(self) -> Bench:
        """The design of the chosen body."""
        if self.at not in self._benches:
            self._benches[self.at] = Bench(self.plans[self.at])
        return self._benches[self.at]

    def content(self) -> Content:
        """Return the body in the pose of the sliders, and its figures."""
        bench = self.bench
        measures, original = self._measures(bench.built), self._measures(bench.plan.original)
        return Content(
            actors=self._shown.actors,
            tables=(figures(bench, measures, original), motors(bench, measures)),
            notes=self._notes(),
            title=f"design of {bench.built.figure.name}",
        )

    def complete(self) -> None:
        """Wait for the figures."""
        for built in (self.bench.plan.original, self.bench.built):
            # Whoever asks first has them computed; they are kept.
            _ = built.measures

    def panel(self, gui: Any, session: Session) -> None:
        """Add sliders, buttons and keys."""
        first = self._session is None
        self._session = session
        self._panel = DesignPanel(gui, session, self)
        if first:
            self._panel.keys()
        self._panel.show()
        self._settle()

    def state(self) -> JSON:
        """Return the chosen body, and each body's parameters and pose."""
        designs = {str(at): bench.state() for at, bench in sorted(self._benches.items())}
        return {"body": self.at, "show_original": self.ghost, "designs": designs}

    def restore(self, state: JSON) -> None:
        """Choose what an earlier state said.

        Raises:
            ViewError: The state is of other bodies or parameters.
        """
        from morph.app.viewer.design.restore import restored

        self.at, self.ghost, choices = restored(self.plans, state)
        for at, choice in choices.items():
            self._benches[at] = Bench(self.plans[at])
            bench = self._benches[at]
            bench.history.now = choice
            bench.take(bench.plan.built(choice.values))
        self._shown = Shown(self.bench, self.ghost)

    def headline(self) -> str:
        """Return mass, reach and margin in one line."""
        bench = self.bench
        return headline(bench, self._measures(bench.built), self._measures(bench.plan.original))

    def choose(self, at: int) -> None:
        """Design another of the bodies."""
        self.at = at
        self._shown_anew(aim=True)
        self._settle()

    def turn(self, joint: str, value: float) -> None:
        """Bring a joint to a position, rad or m."""
        arrived = self.bench.turn(joint, value, time.monotonic())
        self._posed(held=joint if arrived else None)

    def set(self, name: str, value: float | None) -> None:
        """Set a parameter, or with None leave it as described."""
        self.bench.set(name, value, time.monotonic())
        if self._page is not None:
            self._page.tell(held=name)
        self._settle()

    def plain(self) -> None:
        """Leave all parameters as described."""
        self.bench.plain(time.monotonic())
        self._settle()

    def rest(self) -> None:
        """Bring all joints to rest."""
        self.bench.rest(time.monotonic())
        self._shown_anew(aim=True)

    def random(self) -> None:
        """Bring all joints anywhere in their ranges."""
        self.bench.random(self._rng, time.monotonic())
        # Another pose may be out of sight.
        self._shown_anew(aim=True)

    def undo(self) -> None:
        """Go back one step."""
        self._stepped(self.bench.history.undo(), "there is nothing to undo")

    def redo(self) -> None:
        """Go forward one step that was undone."""
        self._stepped(self.bench.history.redo(), "there is nothing to do again")

    def show_original(self, shown: bool) -> None:
        """Show the body as described too, or not."""
        self.ghost = shown
        self._shown_anew()

    def highlight(self, link: str | None) -> None:
        """Highlight a link, or with None nothing any more."""
        if self._session is not None:
            self._session.stage.choose(0, self.bench.seen(link))

    def save(self, name: str) -> None:
        """Save the design as a new body on the user's shelf; what comes of it is told."""
        from morph.app.viewer.design.save import save

        session, bench = self._session, self.bench
        if session is None:
            return
        plan, values = bench.plan, dict(bench.choice.values)

        def work() -> str:
            return save(plan, plan.built(values), name).name

        session.later(work, lambda saved: session.say(f"saved; see it by: morph view {saved}"))

    @property
    def _page(self) -> DesignPanel | None:
        """The controls; None while they are not on the page."""
        session = self._session
        return self._panel if session is not None and session.view is self else None

    def _stepped(self, was: bool, otherwise: str) -> None:
        if not was:
            if self._session is not None:
                self._session.say(otherwise)
            return
        if self.bench.stale:
            self._settle()
        else:
            self.bench.adopt()
            self._posed()

    def _posed(self, held: str | None = None) -> None:
        """Show the pose that the joints have now; the scene stays, its links move."""
        self._shown.pose()
        if self._page is not None:
            self._page.tell(held)
        self._tables(self._session)

    def _tables(self, session: Session | None) -> None:
        if session is not None and session.view is self:
            session.content = replace(session.content, tables=self.content().tables)

    def _shown_anew(self, *, aim: bool = False) -> None:
        self._shown = Shown(self.bench, self.ghost)
        session, panel = self._session, self._page
        if panel is not None:
            panel.show()
        if session is not None and session.view is self:
            session.show(self.content(), still=not aim)
            if aim:
                session.stage.aim(session.client.camera)

    def _settle(self) -> None:
        """Build what is chosen if it is not built, then measure what is not measured."""
        session, bench = self._session, self.bench
        if session is None:
            return
        if bench.stale:
            plan, values = bench.plan, dict(bench.choice.values)
            self._building.ask(
                session,
                lambda: plan.built(values),
                lambda built: self._built(bench, built),
                lambda: self._refused(bench),
            )
        elif not self._known(bench.built) or not self._known(bench.plan.original):
            built, original = bench.built, bench.plan.original
            self._measuring.ask(
                session, lambda: (original.measures, built.measures), lambda _: self._measured()
            )

    def _built(self, bench: Bench, built: Built) -> None:
        bench.take(built)
        if bench is self.bench:
            self._shown_anew()
            self._settle()

    def _refused(self, bench: Bench) -> None:
        """Go back to what is built: what was chosen cannot be."""
        if self._building.busy:
            return
        bench.history.now = replace(bench.choice, values=dict(bench.built.values))
        if self._page is not None and bench is self.bench:
            self._page.tell()

    def _measured(self) -> None:
        if self._page is not None:
            self._page.tell()
        self._tables(self._session)
        self._settle()

    def _measures(self, built: Built) -> Any:
        """Return a body's figures if they are known; nobody waits for them here."""
        return built.measures if self._known(built) else None

    def _known(self, built: Built) -> bool:
        return "measures" in vars(built)

    def _notes(self) -> tuple[str, ...]:
        return (limits_note(self.bench.limits),)


def maker(given: ViewRequest) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page."""
    plans = tuple(BodyPlan(robot) for robot in given.robots)
    return lambda: DesignView(plans, given.seed)
