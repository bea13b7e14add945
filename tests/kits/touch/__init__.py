"""Pads, slides, scenes, effects and frames for tests."""
