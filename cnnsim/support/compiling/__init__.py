"""Compiled loops: kept on disk in folders of this user alone, and Ctrl-C heard while they are made."""
