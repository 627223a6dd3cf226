"""Landmarks stand for all postures near them."""

from __future__ import annotations

import numpy as np
import torch

from morph.model.jointed.landmarks import TOLERANCE, exponential, landmarks


def circle(count: int, length: float) -> torch.Tensor:
    angle = torch.as_tensor(np.random.default_rng(0).uniform(-np.pi, np.pi, count))
    return torch.stack([torch.cos(angle), torch.sin(angle)], dim=-1) / length


def test_products_of_features_are_the_kernel_to_the_tolerance() -> None:
    points = circle(200, 1.0)
    marks = landmarks(points)
    features = marks.features(points)
    # What is left out is positive semidefinite, so no entry exceeds the largest of its diagonal.
    left = exponential(points, points) - features @ features.T
    assert float(left.abs().max()) <= 1.01 * TOLERANCE
    assert len(marks.points) < 15


def test_a_shorter_length_needs_more_landmarks() -> None:
    counts = [len(landmarks(circle(300, length)).points) for length in (3.0, 1.0, 0.3)]
    assert counts == sorted(counts)
    assert counts[0] < counts[2]
