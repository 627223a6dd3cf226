"""Studies and data that stand outside the product: sealed cases, benchmarks, sources."""
