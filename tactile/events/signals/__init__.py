"""Signals of a finger, frame by frame: what detectors see of it, and the compiled loops that make it."""
