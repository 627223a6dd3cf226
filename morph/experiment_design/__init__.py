"""Experiments that show which law acts: motions, what they tell apart, and the plan."""
