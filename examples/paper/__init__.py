"""The paper figure by figure: 3 to 8 the point load on a flat cover, 10 to 12 the bump, 14 and 15 the textures."""
