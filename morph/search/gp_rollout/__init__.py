"""Rollouts of Gaussian-process dynamics, and policies optimised on them."""
