"""What `bench_fluid.py` measures: tensors, conserved energy, and the price of the fluid."""
