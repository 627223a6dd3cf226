"""Diagnosis by one linearisation along a recording: columns, whitened by a Kalman filter."""
