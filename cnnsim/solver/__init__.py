"""Solver: transients to a tolerance, error estimates, steady states, and the distance from them."""
