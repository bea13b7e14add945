"""Import and export of template files of other systems: the readers and writers by format, and the import of a file."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from cnnsim.formats.candy.imported import tem_templates
from cnnsim.formats.candy.parse import read_tem
from cnnsim.formats.candy.write import entry_to_tem, write_tem
from cnnsim.formats.celnn_json import celnn, read_celnn
from cnnsim.formats.cnnsim_text import read_cnnsim
from cnnsim.formats.defects import defects
from cnnsim.formats.gene import read_gene
from cnnsim.formats.matcnn import matcnn_templates, read_matcnn
from cnnsim.library.entry import LibraryEntry
from cnnsim.library.folders import folder as shipped_folder
from cnnsim.library.imported import Imported
from cnnsim.library.read import load_file
from cnnsim.support import Diagnostics, InputError
from cnnsim.support.command_files import check_free
from cnnsim.support.files import make_folder, writing
from cnnsim.support.limits import FOREIGN, TEMPLATES, check_file


def _tem(data: bytes, stem: str, report: Diagnostics) -> list[Imported]:
    tem = read_tem(data, report)
    return [] if report.failed else tem_templates(tem, stem, report)


READERS: dict[str, Callable[[bytes, str, Diagnostics], list[Imported]]] = {
    "tem": _tem,
    "matcnn": lambda data, _, report: matcnn_templates(read_matcnn(data, report), report),
    "cnnsim": read_cnnsim,
    "gene": read_gene,
    "json": lambda data, _, report: read_celnn(data, report),
}
WRITERS: dict[str, Callable[[LibraryEntry], str]] = {
    "tem": lambda entry: write_tem(entry_to_tem(entry)),
    "json": lambda entry: celnn(entry.network, entry.summary, entry.tags),
}
KEPT: dict[str, str] = {
    "tem": "numbers, input, initial state, boundary, running time",
    "json": "numbers, the sign of z changed for black = -1; not the boundary, initial state and running time",
}
"""What of a template each format holds."""
_SUFFIXES = {".tem": "tem", ".m": "matcnn", ".cnnsim": "cnnsim", ".gene": "gene", ".json": "json"}
_SYSTEMS = {"tem": "CANDY", "matcnn": "MATCNN", "cnnsim": "CNNSim", "gene": "M.Teti", "json": "celnn"}
_OF_PARTS = {"matcnn", "json"}  # files of many templates: an error in one leaves the others good


@dataclass
class ImportedFile:
    """Result of the import of a file: its report, the written files, the templates that are not written."""

    report: Diagnostics
    written: list[Path] = field(default_factory=list)
    not_written: list[Imported] = field(default_factory=list)


def file_format(path: Path, given: str | None = None) -> str:
    """Return the format of a file by its suffix.

    Raises:
        InputError: the suffix is not known and no format is given.
    """
    found = given or _SUFFIXES.get(path.suffix.lower())
    if found is None:
        raise InputError(f"the suffix {path.suffix!r} is not known; say --format with one of {', '.join(READERS)}")
    return found


def import_file(path: Path, folder: Path, given: str | None = None, *, replace: bool = False) -> ImportedFile:
    """Read a file and write a template file for every template in it; all complaints are in the report."""
    result = ImportedFile(Diagnostics(str(path)))
    report = result.report
    try:
        kind = file_format(path, given)
        check_file(path, "template file", FOREIGN)
        templates = READERS[kind](path.read_bytes(), path.stem, Diagnostics(path.name, report.items))
        if len(templates) > TEMPLATES:
            raise InputError(f"{len(templates)} templates; {TEMPLATES} in a file at most wanted")
    except (InputError, OSError) as error:
        report.error(None, error.strerror or str(error) if isinstance(error, OSError) else str(error))
        return result
    if report.failed and kind not in _OF_PARTS:
        return result
    for imported in templates:
        imported = _with_defects(imported, path.stem, kind, report)
        if imported.missing:
            report.warning(None, f"{imported.name}: {imported.missing}")
            result.not_written.append(imported)
        elif target := _write(imported, folder, report, replace):
            result.written.append(target)
    return result


def _with_defects(imported: Imported, stem: str, kind: str, report: Diagnostics) -> Imported:
    source_name = stem if kind == "tem" else (imported.aliases or (imported.name,))[0]
    for text in defects(imported, source_name, _SYSTEMS[kind]):
        report.warning(None, f"{imported.name}: {text}")
        imported = imported.with_note(f"Warning: {text}{'' if text.endswith('.') else '.'}")
    return imported


def _write(imported: Imported, folder: Path, report: Diagnostics, replace: bool) -> Path | None:
    target = folder / f"{imported.name}.toml"
    try:
        check_free(target, replace=replace)
    except InputError as error:
        report.error(None, str(error))
        return None
    if (shipped_folder() / target.name).is_file():
        text = f"where {folder} is searched this hides the shipped template of that name"
        report.warning(None, f"{imported.name}: {text}")
    try:
        make_folder(folder)
        with writing(target, replace=True, follow=False) as temporary:
            temporary.write_text(imported.text(), encoding="utf-8")
            try:
                load_file(temporary)
            except InputError as error:  # what was written cannot be used, so it is not kept
                raise InputError(str(error).replace(str(temporary), str(target))) from error
    except InputError as error:
        report.error(None, str(error))
        return None
    return target
