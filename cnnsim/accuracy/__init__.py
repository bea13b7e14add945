"""How far from the truth a transient ends: the exact flow, the rest, error estimates, and runs to a wanted accuracy."""
