"""Entry point of the command line `cnnsim`; everything else is imported after Ctrl-C is handled."""

from cnnsim.start import start


def main() -> None:
    """Run the command line."""
    start("cnnsim.cli.group")
