"""Learning: gradients of transients by their adjoint, and templates that are trained on pairs of pictures."""
