"""Diagnosis: laws as columns along smoothed motions, sets of them refitted, compared and judged."""
