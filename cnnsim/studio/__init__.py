"""The studio: a page in the browser that shows templates, programs and arrays as they run."""

from pathlib import Path

PAGE = Path(__file__).parent / "page"
"""The folder of the page's files."""
