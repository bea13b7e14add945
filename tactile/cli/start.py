"""Where the command line `tactile` begins: all else is imported when Ctrl-C is answered."""

from cnnsim.start import start


def main() -> None:
    """Run the command line."""
    start("tactile.cli.group")
