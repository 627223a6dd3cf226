"""The filter against the joint normal distribution of all states and readings, written out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from morph.arrays import Array
from morph.inference.filter import Disturbance, Tangent, scored, smoothed
from morph.inference.whitened import products, whitened, whitened_blocks

H = 0.01


def case(seed: int, samples: int = 40, dofs: int = 2, columns: int = 3) -> dict[str, Any]:
    """Return a random robot that changes along the run, read through three channels."""
    rng = np.random.default_rng(seed)
    inertia = rng.normal(size=(samples, dofs, dofs)) + 3.0 * np.eye(dofs)
    jacobian = np.concatenate(
        [
            20.0 * rng.normal(size=(samples, dofs, dofs)),
            2.0 * rng.normal(size=(samples, dofs, dofs)),
            inertia @ np.swapaxes(inertia, 1, 2),
        ],
        axis=2,
    )
    reads = np.zeros((3, 2 * dofs))
    reads[0, 0], reads[1, 1], reads[2, dofs] = 1.0, 1.0, 0.7
    return {
        "tangent": Tangent(
            step=H, jacobian=jacobian, reads=reads, valid=rng.random((samples, 3)) < 0.8
        ),
        "disturbance": Disturbance(
            noise=np.array([0.01, 0.03, 0.2]),
            scale=np.array([0.5, 2.0])[:dofs],
            correlation_time=0.07,
            initial=np.full(2 * dofs, 0.3),
            jolt=rng.uniform(0.0, 0.2, (samples, dofs, 4)),
        ),
        "readings": rng.normal(size=(samples, 3, columns)),
        "accelerations": rng.normal(size=(samples, dofs, columns)),
    }


def joint(tangent: Tangent, disturbance: Disturbance) -> tuple[Array, Array, Array]:
    """Return the covariance of all states, their map to valid readings, and that of inputs to them.

    There are (samples (3 dofs + contacts)) states and (samples dofs) inputs.
    """
    samples, dofs, size = tangent.jacobian.shape
    times = np.repeat(
        [disturbance.correlation_time, disturbance.contact_time], [dofs, size - 3 * dofs]
    )
    keep = np.exp(-tangent.step / times)
    scale = np.append(disturbance.scale, np.full(size - 3 * dofs, disturbance.contact))
    forces = np.concatenate([np.zeros((len(keep), 2 * dofs)), np.diag(keep)], axis=1)
    jolt = np.zeros((samples, dofs, 1)) if disturbance.jolt is None else disturbance.jolt
    sources = np.zeros((samples * size, size + samples * (len(keep) + jolt.shape[2])))
    sources[:size, :size] = np.diag(np.concatenate([disturbance.initial, scale]))
    inputs = np.zeros((samples * size, samples * dofs))
    eye = np.eye(dofs, size)
    pushed = np.zeros((size, dofs))
    pushed[: 2 * dofs] = np.tile(tangent.step * np.eye(dofs), (2, 1))
    pushed[:dofs] *= tangent.step
    for t in range(samples - 1):
        velocity = np.roll(eye, dofs, axis=1) + tangent.step * tangent.jacobian[t]
        move = np.concatenate([eye + tangent.step * velocity, velocity, forces])
        now, then = slice(t * size, (t + 1) * size), slice((t + 1) * size, (t + 2) * size)
        sources[then] = move @ sources[now]
        inputs[then] = move @ inputs[now]
        inputs[then, t * dofs : (t + 1) * dofs] += pushed
        first = size + t * len(keep)
        fresh = np.diag(scale * np.sqrt(1.0 - keep**2))
        sources[then.start + 2 * dofs : then.stop, first : first + len(keep)] = fresh
        first = size + samples * len(keep) + t * jolt.shape[2]
        sources[then, first : first + jolt.shape[2]] = pushed / tangent.step @ jolt[t]
    rows = np.concatenate([tangent.reads, np.zeros((len(tangent.reads), len(keep)))], axis=1)
    reads = np.kron(np.eye(samples), rows)[tangent.valid.reshape(-1)]
    return sources @ sources.T, reads, inputs


def covariance(tangent: Tangent, disturbance: Disturbance) -> Array:
    """Return the covariance of all valid readings."""
    states, reads, _ = joint(tangent, disturbance)
    noise = np.tile(disturbance.noise**2, len(tangent.valid))[tangent.valid.reshape(-1)]
    spread = reads @ states @ reads.T + np.diag(noise)
    if disturbance.vibration is not None:
        time = tangent.step * np.arange(len(tangent.valid))
        fades = np.exp(-np.abs(time[:, None] - time) / disturbance.vibration_time)
        whole = np.kron(fades, np.diag(disturbance.vibration**2))
        there = tangent.valid.reshape(-1)
        spread += whole[np.ix_(there, there)]
    return np.asarray(spread)


def vibrating(given: dict[str, Any]) -> dict[str, Any]:
    """Return a case whose readings also vibrate."""
    vibration = np.array([0.05, 0.02, 0.4])
    more = replace(given["disturbance"], vibration=vibration, vibration_time=0.04)
    return {**given, "disturbance": more}


def touching(given: dict[str, Any]) -> dict[str, Any]:
    """Return a case with three directions of contact, one of which ends halfway."""
    tangent, rng = given["tangent"], np.random.default_rng(9)
    samples, dofs, _ = tangent.jacobian.shape
    contact = rng.normal(size=(samples, dofs, 3))
    contact[samples // 2 :, :, 1] = 0.0
    tangent = replace(tangent, jacobian=np.concatenate([tangent.jacobian, contact], axis=2))
    more = replace(given["disturbance"], contact=3.0, contact_time=0.03)
    return {**given, "tangent": tangent, "disturbance": more}


def toppling(given: dict[str, Any]) -> dict[str, Any]:
    """Return a longer case that topples at up to 20 per s, as readings of it that fit tell."""
    more = case(int(given["readings"][0, 0, 0] < 0.0), samples=1500, columns=1)
    tangent = more["tangent"]
    tangent.jacobian[:, :, :2] += 400.0 * np.eye(2)
    return {**more, "readings": 0.01 * more["readings"]}


def as_it_is(given: dict[str, Any]) -> dict[str, Any]:
    """Return a case."""
    return given


@pytest.mark.parametrize("more", [as_it_is, vibrating, touching])
@pytest.mark.parametrize("seed", range(3))
def test_the_gram_matrix_is_that_of_responses_in_the_metric_of_the_readings(
    seed: int, more: Callable[[dict[str, Any]], dict[str, Any]]
) -> None:
    given = more(case(seed))
    tangent = given["tangent"]
    _, reads, inputs = joint(tangent, given["disturbance"])
    columns = given["readings"].shape[2]
    moved = reads @ inputs @ given["accelerations"].reshape(-1, columns)
    shown = given["readings"].reshape(-1, columns)[tangent.valid.reshape(-1)] + moved
    spread = covariance(tangent, given["disturbance"])
    found = whitened(**given)
    exact = shown.T @ np.linalg.solve(spread, shown)
    # Condition numbers near 1e6 leave ten digits.
    assert np.allclose(found.gram, exact, rtol=1e-8, atol=1e-8 * np.abs(exact).max())
    assert found.logarithm == pytest.approx(np.linalg.slogdet(spread)[1], rel=1e-9)
    assert found.readings == len(spread)


def test_the_likelihood_is_that_of_a_normal_distribution() -> None:
    from scipy.stats import multivariate_normal

    given = case(5)
    tangent = given["tangent"]
    reading = given["readings"][:, :, :1]
    spread = covariance(tangent, given["disturbance"])
    exact = multivariate_normal(np.zeros(len(spread)), spread).logpdf(
        reading[:, :, 0][tangent.valid]
    )
    found = whitened(tangent, given["disturbance"], reading)
    assert found.log_likelihood() == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("more", [as_it_is, vibrating, touching])
@pytest.mark.parametrize("seed", range(3))
def test_the_smoothed_state_is_the_mean_given_all_readings(
    seed: int, more: Callable[[dict[str, Any]], dict[str, Any]]
) -> None:
    given = more(case(seed))
    tangent = given["tangent"]
    reading, push = given["readings"][:, :, 0], given["accelerations"][:, :, 0]
    states, reads, inputs = joint(tangent, given["disturbance"])
    known = inputs @ push.reshape(-1)
    surprise = reading[tangent.valid] - reads @ known
    spread = covariance(tangent, given["disturbance"])
    exact = (known + states @ reads.T @ np.linalg.solve(spread, surprise)).reshape(len(reading), -1)
    found, deviation = smoothed(tangent, given["disturbance"], reading, push)
    assert np.allclose(
        found[:, : exact.shape[1]], exact, rtol=1e-7, atol=1e-8 * np.abs(exact).max()
    )
    left = states - states @ reads.T @ np.linalg.solve(spread, reads @ states)
    dofs = deviation.shape[1]
    variance = np.diag(left).reshape(len(reading), -1)[:, dofs : 2 * dofs]
    # Variances of 1e-6 of the prior's keep four digits.
    assert np.allclose(deviation**2, variance, rtol=1e-4, atol=1e-9 * variance.max())


def test_as_many_channels_as_joints_vibrate_alike_in_compiled_sizes() -> None:
    # One column of two joints and two channels runs through loops of fixed length, three do not.
    given = vibrating(case(6))
    tangent = replace(
        given["tangent"], reads=given["tangent"].reads[:2], valid=given["tangent"].valid[:, :2]
    )
    disturbance = replace(
        given["disturbance"],
        noise=given["disturbance"].noise[:2],
        vibration=given["disturbance"].vibration[:2],
    )
    readings = given["readings"][:, :2]
    whole = whitened(tangent, disturbance, readings)
    for at in range(3):
        alone = whitened(tangent, disturbance, readings[:, :, at : at + 1])
        assert alone.gram[0, 0] == pytest.approx(whole.gram[at, at], rel=1e-12)
        assert alone.logarithm == pytest.approx(whole.logarithm, rel=1e-12)


@pytest.mark.parametrize("dofs", [7, 8, 11, 12])
def test_one_column_without_vibration_is_whitened_as_among_others(dofs: int) -> None:
    # Loops of fixed length serve up to 7 joints, with and without as many that vibrate.
    given = case(8, dofs=dofs)
    given["disturbance"] = replace(given["disturbance"], scale=np.linspace(0.5, 2.0, dofs))
    tangent, disturbance = given["tangent"], given["disturbance"]
    whole = whitened(tangent, disturbance, given["readings"])
    for at in range(3):
        alone = whitened(tangent, disturbance, given["readings"][:, :, at : at + 1])
        assert alone.gram[0, 0] == pytest.approx(whole.gram[at, at], rel=1e-9)
        assert alone.logarithm == pytest.approx(whole.logarithm, rel=1e-12)


def test_blocks_of_a_run_add_up_to_it() -> None:
    given = vibrating(case(3))
    whole, parts = whitened(**given), whitened_blocks(**given, blocks=3)
    assert sum(part.gram for part in parts) == pytest.approx(whole.gram)
    assert sum(part.logarithm for part in parts) == pytest.approx(whole.logarithm)
    assert sum(part.readings for part in parts) == whole.readings


def test_a_run_in_stretches_is_the_whole_run(monkeypatch: pytest.MonkeyPatch) -> None:
    given = case(7)
    whole = whitened(**given)
    # 3 channels and 3 columns: stretches of 7 samples, the last of 5.
    monkeypatch.setattr("morph.inference.whitened.CHUNK", 7 * 9)
    parts = whitened(**given)
    assert np.allclose(whole.gram, parts.gram, rtol=1e-12, atol=1e-12 * whole.gram.max())
    assert parts.logarithm == pytest.approx(whole.logarithm, rel=1e-13)


@pytest.mark.parametrize("more", [as_it_is, vibrating, touching, toppling])
@pytest.mark.parametrize("seed", range(2))
def test_the_score_is_the_derivative_of_the_likelihood(
    seed: int, more: Callable[[dict[str, Any]], dict[str, Any]]
) -> None:
    given = more(case(seed))
    tangent, disturbance = given["tangent"], given["disturbance"]
    reading, push = given["readings"][:, :, 0], given["accelerations"][:, :, 0]
    found = scored(tangent, disturbance, reading, push)

    def likelihood(**changes: Array) -> float:
        changed = replace(disturbance, **changes)
        return whitened(tangent, changed, reading[:, :, None], -push[:, :, None]).log_likelihood()

    def slope(name: str, which: Array) -> float:
        up, down = (getattr(disturbance, name) * np.exp(s * 1e-4 * which) for s in (1.0, -1.0))
        return (likelihood(**{name: up}) - likelihood(**{name: down})) / 2e-4

    assert found.log_likelihood == pytest.approx(likelihood(), rel=1e-12)
    # Central differences of a likelihood of some 1e4 nats to 1e-12 of it: 1e-8 / 2e-4 = 5e-5 nats;
    # truncation is 1e-8 / 6 of the third derivative, of the size of the first.
    close = {"rel": 1e-6, "abs": 2e-4}
    assert found.noise == pytest.approx(slope("noise", np.ones(3)), **close)
    for at in range(len(disturbance.scale)):
        by_hand = slope("scale", np.arange(len(disturbance.scale)) == at)
        assert found.scale[at] == pytest.approx(by_hand, **close)
    assert len(found.vibration) == (3 if more is vibrating else 0)
    assert found.contact == pytest.approx(slope("contact", np.array(1.0)), **close)
    for at in range(len(found.vibration)):
        assert found.vibration[at] == pytest.approx(slope("vibration", np.arange(3) == at), **close)


def test_products_with_the_first_columns_are_those_of_the_gram_matrix() -> None:
    given = vibrating(case(4))
    whole = whitened(**given).gram
    across, square = products(**given, first=2)
    assert np.allclose(across, whole[:2], rtol=1e-12)
    assert np.allclose(square, np.diag(whole), rtol=1e-12)


def test_columns_beyond_a_tile_are_whitened_as_alone() -> None:
    given = case(8)
    readings = np.concatenate([given["readings"]] * 50, axis=2)
    moved = np.concatenate([given["accelerations"]] * 50, axis=2)
    # 150 columns: two tiles of 64, and 22 more.
    many = whitened(given["tangent"], given["disturbance"], readings, moved).gram
    once = whitened(**given).gram
    assert np.allclose(many, np.tile(once, (50, 50)), rtol=1e-11, atol=1e-11 * np.abs(once).max())
