"""The study of the SO-101 in small, on real motions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.openloop import BINDINGS
from experiments.so101 import VARY
from morph.body.load import load
from morph.model.episodes import episode, step_for
from morph.model.fit import fit, measure
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.model.score import rmse
from morph.model.segments import cut, scored_segments
from morph.model.shooting import predict
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.load import load_recordings


def test_dry_friction_halves_the_error_of_a_linear_servo_on_a_motion_it_never_saw(
    recordings: Path,
) -> None:
    # The wrist's servo stands still until its command is about 0.02 rad ahead, thirteen
    # counts of its encoder of 0.0015 rad: no gain of a linear servo does that.
    robot = load("so101")
    motions = {
        motion.name: motion
        for motion in load_recordings(
            BINDINGS / "so101.toml", robot=robot, root=recordings / "so101_sage"
        )
        if motion.name in {"dual_joint_elbow_wrist", "hover_positions"}
    }
    train, aside = motions["dual_joint_elbow_wrist"], motions["hover_positions"]
    step = step_for([train], robot)
    segments = cut([episode(train, robot, step)], 1.0, most=8)
    scored = scored_segments([episode(aside, robot, step)], 1.0)
    linear = Hypothesis(robot=robot, step=step, knobs=knobs(robot, VARY))
    rubbing = replace(linear, effects=(CoulombFriction(joint="Wrist_Pitch", c=0.2),))
    wrist = [joint.name for joint in robot.joints].index("Wrist_Pitch")
    read = predict(linear, segments, [linear.start], [segments.start])[0]
    scale, weight = measure(segments, read)
    error = []
    for model in (linear, rubbing):
        found = fit(model, segments, scale, weight, iterations=3)
        predicted = predict(found.hypothesis, scored, [found.point], [scored.start])[0]
        error.append(float(rmse(scored, predicted)[wrist]))
    assert np.isfinite(error).all()
    assert error[1] < 0.5 * error[0]
