"""Entry point of the command line `tactile`; other imports follow once Ctrl-C is handled."""

from cnnsim.start import start


def main() -> None:
    """Run the command line."""
    start("tactile.cli.group")
