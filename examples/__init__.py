"""Short examples; importing one computes nothing."""
