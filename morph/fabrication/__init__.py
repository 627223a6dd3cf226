"""From a body to a package for the printer and back: weigh what came off, match the policy."""
