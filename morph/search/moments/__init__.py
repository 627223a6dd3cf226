"""Mean and variance of what passes through a learned model, in closed form, with gradients."""
