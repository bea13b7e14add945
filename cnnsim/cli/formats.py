"""The commands `import` and `export`: template files of other systems read and written."""

from pathlib import Path

import click

from cnnsim import library
from cnnsim.formats.files import KEPT, READERS, WRITERS, ImportedFile, import_file
from cnnsim.support import InputError, naming
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.files import check_name, write_text
from cnnsim.support.terminal import echo, say


@click.command(
    "import",
    epilog=examples(
        "cnnsim import EDGE.tem HOLE.tem -o my-library/",
        "cnnsim import temlib.m -o my-library/",
        "cnnsim import best.txt --format gene -o my-library/",
        "cnnsim --library my-library list",
    ),
)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), required=True, help="Folder.")
@click.option("--format", "kind", type=click.Choice(list(READERS)), help="Format, where the suffix does not tell.")
@click.option("--replace", is_flag=True, help="Write over template files that are there already.")
@click.option("--notes", is_flag=True, help="Also print harmless findings: stray bytes, a missing CURRENT, ...")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
@click.pass_context
def import_(
    context: click.Context, files: tuple[Path, ...], output: Path, kind: str | None, replace: bool, notes: bool,
    as_json: bool,
) -> None:  # fmt: skip
    """Convert template files of other systems.

    FILES become template files of a library of your own.

    By suffix: .tem (CANDY), .m (MATCNN's temlib.m), .cnnsim (CNNSim text), .gene (19 numbers), .json (celnn).
    Every remark names its file and line; a bad file does not stop the others, and makes the exit code 2.
    """
    results = [import_file(path, output, kind, replace=replace) for path in files]
    if as_json:
        print_json([_facts(result) for result in results])
    else:
        for result in results:
            for line in result.report.lines(notes):
                echo(line, err=True)  # as compilers say it: for editors, on one line
            for target in result.written:
                say(f"{result.report.file} -> {target}")
        say(_summary(results))
    if any(result.report.failed for result in results):
        context.exit(2)


def _facts(result: ImportedFile) -> dict[str, object]:
    remarks = [{"severity": item.severity, "line": item.line, "message": item.message} for item in result.report.items]
    return {
        "file": result.report.file,
        "written": [str(path) for path in result.written],
        "not_written": {imported.name: imported.missing for imported in result.not_written},
        "failed": result.report.failed,
        "diagnostics": remarks,
    }


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _summary(results: list[ImportedFile]) -> str:
    written = sum(len(result.written) for result in results)
    missing = sum(len(result.not_written) for result in results)
    failed = sum(result.report.failed for result in results)
    warnings = sum(len(result.report.of("warning")) for result in results)
    return (
        f"{_counted(len(results), 'file')}: {_counted(written, 'template')} written, {missing} parsed but not written, "
        f"{_counted(failed, 'file')} failed, {_counted(warnings, 'warning')}"
    )


@click.command(
    "export",
    epilog=examples("cnnsim export edge hole-filler --format tem -o out/", "cnnsim export edge --format json -o out/"),
)
@click.argument("names", nargs=-1, required=True)
@click.option("--format", "kind", type=click.Choice(list(WRITERS)), required=True, help="Format to write.")
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), required=True, help="Folder.")
@click.option("--replace", is_flag=True, help="Write over files that are there already.")
@click.pass_context
def export(context: click.Context, names: tuple[str, ...], kind: str, output: Path, replace: bool) -> None:
    """Write templates of the library in other formats.

    NAMES are written as CANDY .tem or as JSON for celnn.

    One that the format cannot hold does not stop the others: it is named, and makes the exit code 2.
    """
    failed = 0
    for name in names:
        target = output / f"{name}.{kind}"
        try:
            with naming(f"{name} as {kind}"):
                check_name(name, "template")  # other names a template goes by may be any text
                text = WRITERS[kind](library.load(name))
            write_text(target, text, replace=replace, follow=False)
        except InputError as error:
            echo(f"Error: {error}", err=True)
            failed += 1
            continue
        say(f"{name} -> {target}")
    if failed < len(names):
        say(f"kept: {KEPT[kind]}")
    if failed:
        echo(f"{len(names) - failed} of {len(names)} templates written", err=True)
        context.exit(2)
