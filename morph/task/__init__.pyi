from .balance import balance as balance
from .gym import environment as environment
from .gym import environments as environments
from .push import Push as Push
from .quantity import JointPositions as JointPositions
from .swing_up import swing_up as swing_up
from .term import Goal as Goal
