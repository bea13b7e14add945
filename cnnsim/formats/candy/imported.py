"""Templates of the library from the content of a ``.tem`` file, with the setting of its headers."""

from dataclasses import replace

from cnnsim.formats.candy.content import Section, TemFile
from cnnsim.formats.candy.header import Setting, read_setting
from cnnsim.formats.candy.terms import section_template
from cnnsim.library.imported import Imported, library_name
from cnnsim.network import Cell, Template, layered
from cnnsim.support import Diagnostics, InputError

_AFTER_DELAY = 10.0  # time constants in which a cell without neighbours is at rest


def tem_templates(tem: TemFile, stem: str, report: Diagnostics) -> list[Imported]:
    """Return every template of the file; one that cannot be written has the reason."""
    setting = read_setting(tem, report)
    sections = [(k, section) for k, section in enumerate(tem.sections) if section.layers]
    templates = [_imported(tem, section, k, stem, setting, report) for k, section in sections]
    if tem.loop is not None:
        first, times = tem.loop
        text = f"The source runs its {len(templates)} templates in turn, {times} times from label {first} on."
        report.warning(None, f"{text} The templates are written, the loop is not")
        templates = [imported.with_note(text) for imported in templates]
    return templates


def _imported(tem: TemFile, section: Section, k: int, stem: str, setting: Setting, report: Diagnostics) -> Imported:
    several = len(tem.sections) > 1
    name = library_name(f"{stem}-{k + 1}" if several else stem)
    title = tem.header("TemLibName").text.strip(" -?.")
    summary = tem.header("Function").text or f"Imported from {stem}.tem, which does not say what it does."
    imported = Imported(
        name, summary, _reference(stem, title), Template([[0.0]], name=name), setting.input, setting.initial_state,
        setting.boundary, setting.duration, note=_note(tem), aliases=_aliases(name, stem, title, several),
    )  # fmt: skip
    try:
        template = section_template(section, name)
    except InputError as error:
        return replace(imported, missing=f"parsed, not written: {error}")
    return _with_setting(replace(imported, network=template), tem, setting, report)


def _with_setting(imported: Imported, tem: TemFile, setting: Setting, report: Diagnostics) -> Imported:
    """Make input and initial state fit the numbers; every change is a warning."""
    line = tem.header("Setting").line or None
    if unsaid := [key for key in ("input", "inistate", "boundary") if key not in setting.given]:
        words = {"input": "input", "inistate": "initial state", "boundary": "boundary"}
        names = ", ".join(words[key] for key in unsaid)
        report.warning(line, f"the header says nothing of {names}; picture and zero-flux are taken: check them")
        imported = imported.with_note(f"The source says nothing of {names}; picture and zero-flux were taken.")
    if imported.network.reads_input and imported.input == "none":
        report.warning(line, "%Setting has no input, but CONTROL is not zero: the picture is taken as input")
        imported = replace(imported, input="picture").with_note("The source names no input; the picture is taken.")
    elif not imported.network.reads_input and imported.input != "none":
        report.note(line, "%Setting has an input, but there is no CONTROL that would use it")
        state = "picture" if imported.initial_state == "given" else imported.initial_state
        imported = replace(imported, input="none", initial_state=state)
    delay = max((term.delay for layer in layered(imported.network).layers for term in layer.terms), default=0.0)
    if delay and imported.duration == "settled":
        imported = replace(imported, duration=delay + _AFTER_DELAY)
        text = f"no running time is given, and with a delay nothing is at rest: {imported.duration:g} time constants"
        report.warning(tem.header("Timing").line or None, f"{text} are written: check them")
        imported = imported.with_note("The source gives no running time; the delay and ten time constants were taken.")
    return replace(imported, cell=Cell("discrete-time" if setting.discrete else "chua-yang"))


def _reference(stem: str, title: str) -> str:
    return f"Imported from {stem}.tem" + (f" ({title})" if title else "")


def _aliases(name: str, stem: str, title: str, several: bool) -> tuple[str, ...]:
    return () if several else tuple(word for word in dict.fromkeys((stem, title)) if word and word != name)


def _note(tem: TemFile) -> str:
    """Return the header fields without a key in template files, as a note."""
    kept = ("Given", "Setting", "Output", "Timing", "CNNModel")
    fields = [(key, tem.header(key).text) for key in kept]
    return " ".join(f"{key}: {text.rstrip('.')}." for key, text in fields if text.strip(" -?.") != "")
