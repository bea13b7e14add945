"""A linear template on a grid as the linear system that it is: its exact flow from kink to kink, and its rest."""
