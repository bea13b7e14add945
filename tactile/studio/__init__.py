"""The live array view: a page in the browser that shows taxels, loads, codes and events of a port or a recording."""

from pathlib import Path

PAGE = Path(__file__).parent / "page"
"""The folder of the page's files."""
