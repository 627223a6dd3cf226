"""Recordings whose truth is sealed, made without MuJoCo and without `morph/physics`."""

from experiments.conceal.case import Case as Case
from experiments.conceal.case import make_cases as make_cases
from experiments.conceal.generate import conceal as conceal
from experiments.conceal.generate import generate as generate
from experiments.conceal.seal import Sealed as Sealed
from experiments.conceal.seal import open_seal as open_seal
