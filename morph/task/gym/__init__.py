"""Tasks as Gymnasium environments, one at a time or many in a batch.

`gymnasium.make("morph.task.gym:morph/CartPole-SwingUp-v0")` imports this package first.
"""

from morph.task.gym.register import environment as environment
from morph.task.gym.register import environment_id as environment_id
from morph.task.gym.register import environments as environments
from morph.task.gym.register import pairs as pairs
from morph.task.gym.register import register_all

# Gymnasium imports this package for what happens here: its "module:name" has no other way to
# make names known. Nothing else imports it.
register_all()
