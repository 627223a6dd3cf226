"""Ways to match a policy to the body that came off the printer, the cheapest first."""
