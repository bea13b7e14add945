"""Prototyping templates: watch a transient, measure how precise a chip must be, design a template from a rule."""
