"""A robot that goes on trying while a service far away improves its policy, when it can."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from morph.body.robot import Robot
from morph.errors import TransferError, TrialStopped
from morph.policy.policy import Policy
from morph.policy_transfer.link.offer import experience_of, experience_said, offer_of
from morph.policy_transfer.link.outbox import Post
from morph.policy_transfer.link.policies import Policies
from morph.search.target import Experience, Target

EXPERIENCE, POLICY, VERDICT = "experience", "policy", "verdict"
"""Kinds of messages: what a trial showed, an offer, and what became of it."""


class OnlineRobot:
    """The robot's side: trials with the safe policy, and messages when the link is up.

    Args:
        target: What is tried on.
        post: The way to the service.
        policies: The safe policies.
    """

    def __init__(self, target: Target, post: Post, policies: Policies) -> None:
        self._target, self._post, self._policies = target, post, policies

    def trial(self, rng: np.random.Generator) -> Experience:
        """Return one trial of the newest safe policy; what it shows is sent when that is possible.

        A policy that drove the body beyond a limit is withdrawn. A dead sensor or a button that
        somebody pressed says nothing of the policy.

        Raises:
            TrialStopped: The trial ended early; what it showed is kept for the service too.
        """
        policy = self._policies.between_trials()
        version = self._policies.version
        try:
            shown = self._target.trial(policy, rng)
        except TrialStopped as stopped:
            if stopped.shown is not None:
                message = experience_said(stopped.shown, version=version, stopped=stopped.what)
                self._post.put(EXPERIENCE, message)
            if stopped.beyond:
                self._policies.withdraw()
            self.exchange()
            raise
        self._post.put(EXPERIENCE, experience_said(shown, version=version))
        self.exchange()
        return shown

    def exchange(self) -> bool:
        """Send and receive what can be; return whether the link was up.

        No policy is taken into use here: that waits for the time between trials.
        """
        up = self._post.exchange()
        for message in self._post.waiting():
            if message.kind == POLICY:
                version = message.content.get("version")
                try:
                    self._policies.offer(message.content)
                    verdict = {"version": version, "accepted": True, "why": ""}
                except TransferError as error:
                    verdict = {"version": version, "accepted": False, "why": error.what}
                self._post.put(VERDICT, verdict)
            self._post.handled(message)
        return up


class Service:
    """The other side: it learns of trials, and offers policies.

    Args:
        post: The way to the robot.
        robot: The body.
        improve: From all experiences so far to a better policy; None for none yet.
    """

    def __init__(
        self,
        post: Post,
        robot: Robot,
        improve: Callable[[list[Experience]], Policy | None],
    ) -> None:
        self._post, self._robot, self._improve = post, robot, improve
        self.experiences: list[Experience] = []
        """What trials showed, in the order of trials if they arrived together."""
        self.refused: list[str] = []
        """Why the robot refused policies, in words."""

    def serve(self) -> bool:
        """Receive, learn and offer once; return whether the link was up."""
        up, new = self._post.exchange(), False
        for message in self._post.waiting():
            if message.kind == EXPERIENCE:
                try:
                    self.experiences.append(experience_of(message.content))
                    new = True
                except TransferError as error:
                    self.refused.append(error.what)
            elif message.kind == VERDICT and message.content.get("accepted") is not True:
                self.refused.append(str(message.content.get("why")))
            self._post.handled(message)
        if new:
            policy = self._improve(self.experiences)
            if policy is not None:
                # The numbers of messages grow even when the service is started anew.
                version = self._post.last + 1
                self._post.put(POLICY, offer_of(policy, self._robot, version=version))
                self._post.exchange()
        return up
