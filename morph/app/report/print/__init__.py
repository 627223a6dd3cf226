"""The report of a package: what is printed, what it weighs, and what the policy makes of it."""
