"""Models of what was recorded: screening, fitting, choosing, and the finding in words."""
