"""Accuracy of transients: solution to a tolerance, error estimates, and the distance from a steady state."""
