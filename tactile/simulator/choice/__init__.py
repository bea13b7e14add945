"""Choosing effects: their sizes and costs in a scene, bounds of what leaving them out changes, and whether it pays."""
