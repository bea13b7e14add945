"""Planes of a program that lie on the disk: a backend that does its verbs on them block by block, and can go on."""
