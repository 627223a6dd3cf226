"""Searches: from a task and a simulator, or from trials alone, to a policy."""
