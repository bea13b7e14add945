"""Short things to try, each silent on import."""
