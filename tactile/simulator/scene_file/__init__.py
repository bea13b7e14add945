"""Scene files: TOML with tables of arrays, contacts, effects and covers, and a choice that is kept as one."""
