"""Where the command line `cnnsim` begins: all else is imported when Ctrl-C is answered."""

from cnnsim.start import start


def main() -> None:
    """Run the command line."""
    start("cnnsim.cli.group")
