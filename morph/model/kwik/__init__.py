"""Is a model good enough for a target, and for a task on it? Answers that may be "cannot say"."""
