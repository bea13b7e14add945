"""Learned detectors: templates on the planes of the taxels, fitted to labelled recordings and simulated grasps."""
