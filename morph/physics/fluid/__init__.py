"""The fluid: added mass, buoyancy, drag, and the surfaces and tensors behind them."""
