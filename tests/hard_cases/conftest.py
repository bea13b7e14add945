"""The fixture `backend`: every backend and dtype in turn."""

from tests.backends.conftest import backend

__all__ = ["backend"]
