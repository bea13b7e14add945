"""The command that lists the planes a detector can have."""

import click

from cnnsim.support.command_line import examples, print_json
from cnnsim.support.echo import echo


@click.command(epilog=examples("tactile planes", "tactile planes --json"))
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def planes(as_json: bool) -> None:
    """List the planes that detectors are given, with their meaning and scale."""
    from tactile.events.detector_file import shipped_detectors  # the machine is not for --help
    from tactile.events.planes import meanings  # the same
    from tactile.events.registry import SHIPPED  # the same

    found = dict(meanings())
    for detector in shipped_detectors(SHIPPED):
        for name in detector.program.outputs:
            found.setdefault(name, f"output of {detector.name}: {detector.program.summary}")
    if as_json:
        print_json(found)
        return
    for name, what in found.items():
        echo(f"{name:<16} {what}")
