"""The commands `list` and `explain`: what the library has, and how a template would be computed."""

import click

from cnnsim import library
from cnnsim.cli.run import json_option, without_option
from cnnsim.library import folders
from cnnsim.library.explain import explain as explanation
from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.echo import echo


@click.command(
    "list",
    epilog=examples("cnnsim list", "cnnsim list --tag morphology", "cnnsim list --programs", "cnnsim list --json"),
)
@click.option("--tag", help="Only templates of one family.")
@click.option("--programs", is_flag=True, help="The programs instead of the templates, with what they take and give.")
@json_option
def list_(tag: str | None, programs: bool, as_json: bool) -> None:
    """List the templates of the library, or its programs."""
    if programs:
        if tag is not None:
            raise InputError("programs have no tags; --tag goes with templates")
        _list_programs(as_json)
        return
    entries = [library.load(name) for name in library.names(tag)]
    if not entries:
        tags = sorted({tag for name in library.names() for tag in library.load(name).tags})
        raise InputError(f"no template has the tag {tag!r}; tags are {', '.join(tags)}")
    if as_json:
        keys = ("name", "summary", "tags", "reference", "margin")
        print_json([{key: getattr(entry, key) for key in keys} | {"file": str(entry.file)} for entry in entries])
        return
    width = max(len(entry.name) for entry in entries)
    for entry in entries:
        own = "" if entry.shipped else f"  [{entry.file}{'' if entry.examples else ', no worked example'}]"
        margin = f"  (small margin: {entry.margin:g})" if entry.margin is not None and entry.margin < 0.5 else ""
        echo(f"{entry.name:<{width}}  {entry.summary}{margin}{own}")


def _list_programs(as_json: bool) -> None:
    from cnnsim.program.file import load_program

    found = {name: load_program(path) for name, path in folders.programs().items()}
    if as_json:
        keys = ("summary", "inputs", "outputs")
        print_json(
            [{"name": n} | {key: getattr(p, key) for key in keys} | {"file": str(p.path)} for n, p in found.items()]
        )
        return
    width = max(map(len, found))
    for name, program in found.items():
        own = "" if program.path and program.path.is_relative_to(library.folder()) else f"  [{program.path}]"
        echo(f"{name:<{width}}  {program.summary}{own}")
        echo(f"{'':<{width}}    {', '.join(program.inputs)} -> {', '.join(program.outputs)}")


@click.command(epilog=examples("cnnsim explain edge", "cnnsim explain hole-filler --size 512x512 --without sleep"))
@click.argument("name")
@click.option("--size", default="64x64", show_default=True, help="Grid as ROWSxCOLS.")
@without_option
@json_option
def explain(name: str, size: str, without: tuple[str, ...], as_json: bool) -> None:
    """Print what the plan decides for a template, and why."""
    try:
        rows, cols = (int(part) for part in size.lower().split("x"))
        if min(rows, cols) < 1:
            raise ValueError
    except ValueError as error:
        raise InputError(f"size {size!r}; ROWSxCOLS wanted, such as 64x64") from error
    found = explanation(name, (rows, cols), without=without)
    if as_json:
        plan, known = found.plan, found.guaranteed
        facts = {"template": name, "method": plan.method, "step": plan.step, "decisions": plan.decisions}
        print_json(facts | {"guaranteed_time": known.time, "why": known.why, "assuming": known.assuming})
    else:
        echo(str(found))
