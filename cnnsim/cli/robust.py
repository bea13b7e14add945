"""The command `robust`: error rate of a template with imprecise entries, few bits and noise."""

from pathlib import Path

import click

from cnnsim import library
from cnnsim.cli.pictures import binary_option, check_plot, range_option
from cnnsim.cli.run import json_option
from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, progress, replace_option
from cnnsim.support.pictures.read import read_picture, read_pictures
from cnnsim.support.terminal import echo, say, say_table


@click.command(
    epilog=examples(
        "cnnsim robust edge -o curve.png",
        "cnnsim robust hole-filler --draws 100 -o filler.png",
        "cnnsim robust edge-gray --picture photo.jpg -o gray.png",
        "cnnsim robust corner --json",
    )
)
@click.argument("name")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Where the curves go (PNG, SVG, PDF).")
@click.option(
    "--picture", "pictures", type=click.Path(path_type=Path), multiple=True,
    help="Judge on this picture, folder, GIF, video, .npy or .npz; may be repeated.",
)  # fmt: skip
@click.option("--state", type=click.Path(path_type=Path), help="The second picture, for templates that take one.")
@binary_option
@range_option
@click.option("--draws", type=click.IntRange(1, 10_000), default=40, show_default=True, help="Random chips a level.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@replace_option
@json_option
def robust(
    name: str, output: Path | None, pictures: tuple[Path, ...], state: Path | None, binary: bool,
    levels: tuple[float, float] | None, draws: int, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Measure how precise a chip must be for a template.

    The margin, and the share of wrong cells under random errors of the entries (0.1 % to 20 %), entries of 3 to 12
    bits, and noise on the picture. It is judged on black-and-white neighbourhoods where those are all that the template
    sees, else on its own worked pictures; or on pictures of yours.
    """
    from cnnsim.prototyping.robust.error_rate import shown_to
    from cnnsim.prototyping.robust.robust import measure

    check_plot(output)
    claim(output)
    entry, shown = library.load(name), []
    if pictures:
        planes = read_pictures(*pictures, binary=binary, levels=levels)
        second = None if state is None else read_picture(state, binary=binary, levels=levels)
        shown = shown_to(entry, planes, second)
    elif state is not None:
        raise InputError("--state goes with --picture, of which none was given")
    with progress(name) as track:
        found = measure(entry, draws=draws, seed=seed, track=track, shown=shown)
    if output is not None:
        from cnnsim.prototyping.robust.report import draw_robustness

        draw_robustness(found, output)
    if as_json:
        curves = {kind: vars(getattr(found, kind)) for kind in ("entries", "bits", "noise")}
        print_json({"template": name, "margin": vars(found.margin), "judged_on": found.judged_on, **curves,
                    "bits_needed": found.bits_needed(), "draws": draws, "seed": seed})  # fmt: skip
        return
    say(f"{name}, judged on {found.judged_on}")
    say_table(found.rows())
    if output is not None:
        echo(f"-> {output}")
