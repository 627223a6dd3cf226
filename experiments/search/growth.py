"""How the price of a search grows: with the body, with the horizon, and with the data."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from morph.arrays import JSON
from morph.body.load import load
from morph.model.gp.fit import fit
from morph.search.trajectory.cost import TaskCost
from morph.search.trajectory.ddp import Trajectories, ddp
from morph.search.trajectory.plant import Plant
from morph.sim.threads import one_thread
from morph.task.task import Task
from morph.task.tasks import task

BODIES = (
    ("pendulum", "balance"),
    ("cartpole", "balance"),
    ("cart_two_links", "balance"),
    ("cart_three_links", "balance"),
    ("cart_five_links", "balance"),
    ("biped", "stand"),
    ("hexapod_swimmer", "swim"),
    ("quadruped_printed", "walk"),
    ("sea_snake", "swim"),
    ("humanoid", "stand"),
)
"""Bodies of 1 to 31 degrees of freedom, each with a task of its own."""

PERIODS = 50
"""Control periods of a plan, where the body varies."""


def fastest(work: Callable[[], object], *, repeats: int) -> float:
    """Return the least wall time of a piece of work, s."""
    taken = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        taken.append(time.perf_counter() - began)
    return min(taken)


def planning(wanted: Task, periods: int, *, repeats: int) -> tuple[int, float]:
    """Return degrees of freedom and wall time, s, of one step of dynamic programming.

    It is all of it: derivatives by differences, the backward pass, and the search along the line.
    """
    shorter = replace(wanted, horizon=periods * wanted.period)
    simulator = shorter.simulator()
    plant = Plant(simulator, shorter.period)
    model = plant.model
    q, v = shorter.start.sample(shorter.robot, model, 1, None)
    size = 2 * model.nv
    cost = TaskCost(
        task=shorter,
        plant=plant,
        effort=0.01,
        rest=np.zeros(model.nu),
        goal=(q[0], v[0]),
        beyond=np.zeros((size, size)),
    )
    command = np.zeros((1, periods, model.nu))
    positions, velocities = plant.rollout(q, v, command)
    start = Trajectories(
        position=positions, velocity=velocities, command=command, cost=np.array([np.inf])
    )
    return model.nv, fastest(lambda: ddp(plant, cost, start, most=1), repeats=repeats)


def by_body(bodies: Sequence[tuple[str, str]], *, repeats: int) -> list[JSON]:
    """Return what one step of dynamic programming takes on each body."""
    found = []
    for body, name in bodies:
        freedoms, seconds = planning(task(name, load(body)), PERIODS, repeats=repeats)
        found.append({"robot": body, "freedoms": freedoms, "seconds": seconds})
    return found


def by_horizon(periods: Sequence[int], *, repeats: int) -> list[JSON]:
    """Return what one step of dynamic programming takes on the cart-pole."""
    wanted = task("swing-up", load("cartpole"))
    return [
        {"periods": count, "seconds": planning(wanted, count, repeats=repeats)[1]}
        for count in periods
    ]


def by_data(sizes: Sequence[int], *, repeats: int) -> list[JSON]:
    """Return what fitting a Gaussian process and asking it 1000 times takes, by its data."""
    found = []
    for size in sizes:
        rng = np.random.default_rng(size)
        inputs = rng.normal(size=(size, 5))
        targets = np.stack([np.sin(inputs[:, 0]) * inputs[:, 4], inputs[:, 1] ** 2], axis=1)
        targets += rng.normal(scale=0.05, size=targets.shape)
        with one_thread():
            began = time.perf_counter()
            process = fit(inputs, targets)
            fitted = time.perf_counter() - began
        asked = rng.normal(size=(1000, 5))
        found.append(
            {
                "data": size,
                "fit_s": fitted,
                "predict_s": fastest(lambda p=process, a=asked: p.predict(a), repeats=repeats),  # type: ignore[misc]
            }
        )
    return found


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the power with which y grows with x, over the upper half of x."""
    half = len(x) // 2
    return float(np.polyfit(np.log(x[half:]), np.log(y[half:]), 1)[0])


def drawn(growth: JSON) -> str:
    """Return a page with the three curves."""
    from plotly.subplots import make_subplots

    titles = ("degrees of freedom", "control periods of the plan", "data points")
    figure = make_subplots(rows=1, cols=3, subplot_titles=[f"by {each}" for each in titles])
    curves = (
        (1, "bodies", "freedoms", "seconds", "a step of dynamic programming", "robot"),
        (2, "horizons", "periods", "seconds", "the same, cart-pole", None),
        (3, "data", "data", "fit_s", "fitting a Gaussian process", None),
        (3, "data", "data", "predict_s", "1000 predictions", None),
    )
    for column, key, x, y, name, label in curves:
        rows = growth[key]
        figure.add_scatter(
            x=[row[x] for row in rows],
            y=[row[y] for row in rows],
            text=[row[label] for row in rows] if label else None,
            name=name,
            mode="lines+markers",
            row=1,
            col=column,
        )
    for column, title in enumerate(titles, 1):
        figure.update_xaxes(title=title, type="log", row=1, col=column)
        figure.update_yaxes(title="seconds", type="log", row=1, col=column)
    figure.update_layout(template="plotly_white", font={"size": 14})
    return str(figure.to_html(include_plotlyjs=True, full_html=True))
