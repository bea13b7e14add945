"""The command `list`: templates or programs of the library, and invalid files with their errors."""

from pathlib import Path

import click

from cnnsim.cli.run import json_option
from cnnsim.library import folders
from cnnsim.library.catalogue import sound
from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.terminal import say_table


@click.command(
    "list",
    epilog=examples("cnnsim list", "cnnsim list --tag morphology", "cnnsim list --programs", "cnnsim list --json"),
)
@click.option("--tag", help="Only templates of one family.")
@click.option("--programs", is_flag=True, help="The programs instead of the templates, with what they take and give.")
@json_option
def list_(tag: str | None, programs: bool, as_json: bool) -> None:
    """List the templates of the library, or its programs.

    An invalid file is listed as BROKEN with its error.
    """
    if programs:
        if tag is not None:
            raise InputError("programs have no tags; --tag goes with templates")
        _list_programs(as_json)
        return
    entries, broken = sound()
    tags = sorted({tag for entry in entries for tag in entry.tags})
    if tag is not None:
        entries, broken = [entry for entry in entries if tag in entry.tags], {}
    if not entries and not broken:
        raise InputError(f"no template has the tag {tag!r}; tags are {', '.join(tags)}")
    if as_json:
        keys = ("name", "summary", "tags", "reference", "margin")
        facts = [{key: getattr(entry, key) for key in keys} | {"file": str(entry.file)} for entry in entries]
        print_json([*facts, *_broken_facts(broken)])
        return
    rows = []
    for entry in entries:
        own = "" if entry.shipped else f"  [{entry.file}{'' if entry.examples else ', no worked example'}]"
        margin = f"  (small margin: {entry.margin:g})" if entry.margin is not None and entry.margin < 0.5 else ""
        rows.append((entry.name, f"{entry.summary}{margin}{own}"))
    say_table([*rows, *_broken_rows(broken)])


def _list_programs(as_json: bool) -> None:
    from cnnsim.program.file import load_program

    found, broken = {}, {}
    for name, path in folders.programs().items():
        try:
            found[name] = load_program(path)
        except InputError as error:
            broken[path] = error
    if as_json:
        keys = ("summary", "inputs", "outputs")
        facts = [{"name": n} | {key: getattr(p, key) for key in keys} | {"file": str(p.path)} for n, p in found.items()]
        print_json([*facts, *_broken_facts(broken)])
        return
    rows = []
    for name, program in found.items():
        own = "" if program.shipped else f"  [{program.path}]"
        rows.append((name, f"{program.summary}{own}"))
        rows.append(("", f"  {', '.join(program.inputs)} -> {', '.join(program.outputs)}"))
    say_table([*rows, *_broken_rows(broken)])


def _broken_facts(broken: dict[Path, InputError]) -> list[dict[str, str]]:
    return [{"name": path.stem, "file": str(path), "error": str(error)} for path, error in broken.items()]


def _broken_rows(broken: dict[Path, InputError]) -> list[tuple[str, str]]:
    return [(path.stem, f"BROKEN: {error}") for path, error in broken.items()]
