"""Independent answers of elasticity: half-space, layer, bump, and what is located from strains."""
