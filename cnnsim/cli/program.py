"""The command `program`: an analogic program run on pictures, or step by step on sequences of pictures."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from cnnsim import backends
from cnnsim.cli.large import (
    black_cells,
    block_option,
    check_engine_options,
    engine_option,
    machine_on_engine,
    sequence_of_large,
    store_option,
    workers_option,
    write_result,
)
from cnnsim.cli.pictures import FRAME_RATE, arrow, binary_option, bits_option, range_option
from cnnsim.cli.run import backend_option, device_option, json_option, threads_option
from cnnsim.support import Array, InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.files import check_folder, make_folder
from cnnsim.support.pictures.film import filming, is_film
from cnnsim.support.pictures.picture import check_bits, write_picture
from cnnsim.support.pictures.read import sequence_of
from cnnsim.support.pictures.sequence import PictureOptions, PictureSequence
from cnnsim.support.terminal import say

_SHOWN = 10
"""Up to this number of steps every result is printed; above it, minimum and maximum."""


@click.command(
    epilog=examples(
        "cnnsim program opening --input picture=scan.png -o out/",
        "cnnsim program gray-opening --input picture=photo.png --set radius=2 -o gray/",
        "cnnsim program motion-detection --input frame=f1.png --input frame=f2.png -o out/",
        "cnnsim program motion-detection --input frame=walk.mp4 --binary -o moving.gif",
        "cnnsim program count-objects --input picture=scan.png --engine processes --store blocks/ --json",
        "cnnsim program my-program.toml --input a=left/ --input b=right/ --still mask=mask.png -o out/ --json",
    )
)
@click.argument("file")
@click.option(
    "--input", "pairs", multiple=True, metavar="NAME=PICTURES",
    help="A picture for an input plane; repeated, a folder, a GIF, a video, .npy or .npz: a sequence.",
)  # fmt: skip
@click.option("--still", "stills", multiple=True, metavar="NAME=PICTURE",
              help="One picture for an input plane, the same in all steps.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="NAME=NUMBER", help="A number for one of its parameters.")
@click.option("-o", "--output", type=click.Path(path_type=Path),
              help="Folder for the output planes, a file each and for each step; or a film (.gif, .mp4).")  # fmt: skip
@click.option("--format", "ending", type=click.Choice(["png", "tif", "npy"]), default="png", show_default=True,
              help="Of the files in the folder; npy holds the numbers themselves.")  # fmt: skip
@bits_option
@binary_option
@range_option
@backend_option
@device_option
@threads_option
@engine_option
@store_option
@workers_option
@block_option
@replace_option
@json_option
def program(
    file: str, pairs: tuple[str, ...], stills: tuple[str, ...], settings: tuple[str, ...], output: Path | None,
    binary: bool, levels: tuple[float, float] | None, backend: str, device: str | None,
    threads: int | None, as_json: bool, engine: str | None, store: Path | None, workers: int | None,
    block: int | None, ending: str, bits: int,
) -> None:  # fmt: skip
    """Run an analogic program on pictures or sequences.

    FILE is a TOML file, or the name of a program of the library.

    On sequences it runs once for each picture, in order, and keeps the planes under `keep` in between. All inputs have
    the same number of pictures. With --engine planes lie on the disk, and its results stay in the store as Zarr
    arrays (outputs/NAME); what was stopped goes on when the same command is given again.
    """
    from cnnsim.program.file import load_program
    from cnnsim.program.machine import UniversalMachine

    check_engine_options(engine, store, workers, block)
    parsed = load_program(
        file, parameters={key: _number(key, text) for key, text in _pairs("--set", settings, once=True)}
    )
    where = backends.get(backend, device=device, threads=threads)
    reading = PictureOptions(binary, levels, where.dtype)
    large = engine is not None or store is not None
    film = output is not None and is_film(output)
    if large and film:
        raise InputError(f"{output} with --engine; a folder for pictures, or no engine, wanted")
    if output is not None and not film:
        check_folder(output)
        check_bits(f"plane.{ending}", bits)
    sequence = sequence_of_large if large else sequence_of
    inputs = _sequences(_pairs("--input", pairs), _pairs("--still", stills), reading, sequence)
    steps = _steps(inputs, {key for key, _ in _pairs("--still", stills)})
    numbers: dict[str, list[Any]] = {name: [] for name in parsed.outputs}
    files: dict[str, list[Path]] = {name: [] for name in parsed.outputs}
    planes = [name for name in parsed.outputs if parsed.memory[name] != "wire"]
    rate = next((sequence.rate for sequence in inputs.values() if sequence.rate), FRAME_RATE)
    several = steps != 1
    if output is not None and not film:
        claim(*(output / f"{name}{'-0000' * several}.{ending}" for name in planes))
    with ExitStack() as films:
        adding = {}
        chosen = {"engine": engine, "store": store, "workers": workers, "side": block}
        machine = machine_on_engine(where, chosen, films) if large else UniversalMachine(where)
        if film and output is not None:
            for name in planes:
                path = output if len(planes) == 1 else output.with_stem(f"{output.stem}-{name}")
                adding[name], files[name] = films.enter_context(filming(path, rate)), [path]
        for number, pictures in enumerate(watched(_pictures(inputs, steps), parsed.name, steps)):
            for name, value in machine.run(parsed, **pictures).items():
                if isinstance(value, int):
                    numbers[name].append(value)
                    continue
                black = black_cells(value) if large else int((value > 0).sum())
                numbers[name].append({"black": black, "shape": value.shape})
                if name in adding:
                    adding[name](value)
                elif output is not None:
                    make_folder(output)
                    files[name].append(output / (f"{name}-{number:04d}.{ending}" if several else f"{name}.{ending}"))
                    if large:
                        write_result(value, files[name][-1])
                    else:
                        write_picture(value, files[name][-1], bits=bits, follow=False)
                elif store is not None:
                    files[name].append(Path(value.store.root) / value.path)
    _report(parsed.name, numbers, files, several, as_json)


def _sequences(
    pairs: list[tuple[str, str]],
    stills: list[tuple[str, str]],
    reading: PictureOptions,
    sequence: Callable[..., PictureSequence],
) -> dict[str, PictureSequence]:
    given: dict[str, list[str]] = {}
    for key, path in pairs:
        given.setdefault(key, []).append(path)
    for key, path in stills:
        if key in given:
            raise InputError(
                f"--still {key}={path}: {key} is given already; one picture, or --input for several, wanted"
            )
        given[key] = [path]
    return {key: sequence(paths, reading, key) for key, paths in given.items()}


def _steps(inputs: dict[str, PictureSequence], stills: set[str]) -> int | None:
    """Return the number of steps, None if it is not known before the end of a video."""
    for key in stills:
        if (count := inputs[key].count()) != 1:
            raise InputError(f"--still {key}: {count} pictures; a single one wanted")
    moving = {key: sequence for key, sequence in inputs.items() if key not in stills}
    if not moving:
        return 1
    if len(moving) == 1 and next(iter(moving.values())).long:
        return None
    counts = {key: sequence.count() for key, sequence in moving.items()}
    if len(set(counts.values())) > 1:
        lengths = ", ".join(f"{key} has {count} picture{'s' * (count != 1)}" for key, count in counts.items())
        raise InputError(
            f"sequences of different lengths: {lengths}; as many of each wanted (--still: one for all steps)"
        )
    return next(iter(counts.values()))


def _pictures(inputs: dict[str, PictureSequence], steps: int | None) -> Iterator[dict[str, Array]]:
    """Yield the inputs of each step; a still picture is the same in all."""
    going = {key: sequence.pictures() for key, sequence in inputs.items()}
    held: dict[str, Array] = {}
    number = 0
    while number != steps:
        for key, pictures in going.items():
            picture = next(pictures, None)
            if picture is None and (steps is None or key not in held):
                return
            if picture is not None:
                held[key] = picture
        yield dict(held)
        number += 1


def _report(
    name: str, numbers: dict[str, list[Any]], files: dict[str, list[Path]], several: bool, as_json: bool
) -> None:
    steps = max(map(len, numbers.values()), default=0)
    if as_json:
        found: dict[str, Any] = numbers if several else {key: values[0] for key, values in numbers.items()}
        print_json({"program": name} | ({"steps": steps} if several else {}) | {"outputs": found})
        return
    if several:
        say(f"{name}: {steps} steps")
    for key, values in numbers.items():
        plane = isinstance(values[0], dict)
        counts = [value["black"] if plane else value for value in values]
        shown = " ".join(map(str, counts)) if steps <= _SHOWN else f"{min(counts)} to {max(counts)}"
        say(f"{key}: {shown}{' black cells' if plane else ''}" + arrow(files[key]))


def _pairs(option: str, pairs: tuple[str, ...], *, once: bool = False) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    for pair in pairs:
        key, _, value = pair.partition("=")
        if not key or not value:  # an empty path would be the folder one is in
            raise InputError(f"{option} {pair!r}; NAME=VALUE wanted")
        if once and key in dict(found):
            raise InputError(f"{option} {pair}: {key} is {dict(found)[key]} already; one value wanted")
        found.append((key, value))
    return found


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise InputError(f"--set {name}={text}; a number wanted") from error
    return int(value) if value.is_integer() else value
