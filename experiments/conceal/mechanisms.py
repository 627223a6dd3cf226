"""The mechanisms whose truth can be concealed."""

from __future__ import annotations

from experiments.conceal.cartpole import Cartpole
from experiments.conceal.double_pendulum import DoublePendulum
from experiments.conceal.equations import Equations
from experiments.conceal.pendulum import Pendulum

MECHANISMS: dict[str, Equations] = {
    mechanism.name: mechanism for mechanism in (Pendulum(), Cartpole(), DoublePendulum())
}
