"""Independent answers of elasticity: half-space, layer, bump, and loads located from strains."""
