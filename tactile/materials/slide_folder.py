"""Slides of a folder: NPZ files of slides, and recordings whose material is given by a label or the folder name."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.progress import watcher
from tactile import pipeline
from tactile.core.source import Source, provenance
from tactile.materials.slide import Slide
from tactile.materials.slide_file import blocks, is_slide_file, read_slide_file
from tactile.materials.slide_labels import SlideLabel
from tactile.pipeline import FrameReport
from tactile.settings import Settings
from tactile.sources import is_bag, layout_of, open_source, recordings_in

if TYPE_CHECKING:
    from tactile.layout.layout import Layout

PRESSED = 0.2
"""Part of the firm load above which a finger is pressed: a slide lasts from the first to the last such time."""
FIRM = 95
"""Percentile of the normal load that is the firm load."""


def read_slides(
    path: Path, labels: list[SlideLabel] | None = None, layout: "Layout | Path | None" = None
) -> list[Slide]:
    """Return the slides of a file or of all files in a folder.

    An NPZ file of slides has their materials. In any other recording or scene each finger makes one slide, from the
    load of the pipeline. Its material comes from the ``labels``, else from the name of its folder within ``path``. With
    labels, recordings without one are skipped. ``layout``: that of tables of other programs.

    Raises:
        InputError: no slides, a label without its recording, or errors of a reader.
    """
    layout = layout_of(path, layout)
    files = _files(path, layout)
    if labels is not None and (missing := {one.recording for one in labels} - {file.stem for file, _ in files}):
        raise InputError(f"{path}: no recording {', '.join(sorted(missing))}, which the labels name")
    slides: list[Slide] = []
    loose: list[int] = []  # without a block
    watch = watcher()
    for n, (file, folder) in enumerate(files):
        if watch is not None:
            watch(n / len(files), f"reading {file.name}")
        if is_slide_file(file):
            slides += read_slide_file(file)
            continue
        mine = [SlideLabel(file.stem, folder)]
        if labels is not None:
            mine = [one for one in labels if one.recording == file.stem]
        if mine:
            for label, slide in _slides(open_source(file, layout), mine):
                loose += [len(slides)] if label.block is None else []
                slides.append(slide)
    if not slides:
        raise InputError(f"{path}: no slides in it; files of slides, or recordings in which something presses, wanted")
    parts = blocks([slides[n].material for n in loose], range(len(loose)))
    for n, block in zip(loose, parts, strict=True):
        slides[n] = replace(slides[n], block=block)
    return slides


def _files(path: Path, layout: "Layout | None") -> list[tuple[Path, str]]:
    """Return the files to read, each with the name of its folder within ``path``."""
    if not path.is_dir() or is_bag(path):
        return [(path, "")]
    inside = [one for one in sorted(path.iterdir()) if one.is_dir() and not is_bag(one)]
    labelled = [(one, up.name) for up in inside for one in recordings_in(up, layout)]
    return [(one, "") for one in recordings_in(path, layout)] + labelled


class _Loads:
    """A sink that collects the loads of each finger: time, Q, R, F."""

    def __init__(self) -> None:
        self.rows: dict[str, list[tuple[float, float, float, float]]] = {}

    def __call__(self, report: FrameReport) -> None:
        load = report.load
        self.rows.setdefault(report.array.name, []).append((report.frame.t, load.Q, load.R, load.F))


def _slides(source: Source, labels: list[SlideLabel]) -> Iterator[tuple[SlideLabel, Slide]]:
    """Yield the slides of the fingers of a recording: the labelled interval, else the pressed one."""
    seen = _Loads()
    pipeline.run(source, Settings(tare="auto" if provenance(source).untared else "off"), [seen])
    for number, array in enumerate(source.arrays):
        rows = np.array(seen.rows.get(array.name, []), dtype=np.float64).reshape(-1, 4)
        rows = rows[np.isfinite(rows).all(axis=1)]
        t, normal = rows[:, 0], rows[:, 3]
        new = np.diff(t, prepend=-np.inf) > 0
        for label in labels:
            if label.finger not in (None, number) or not new.any():
                continue
            start, stop = (float("nan") if at is None else at for at in (label.start, label.stop))
            use = new & ~(t < start) & ~(t > stop)  # a missing limit is open
            if np.isnan(start) and np.isnan(stop):
                use &= normal > PRESSED * np.percentile(normal, FIRM)
            if use.any():
                name = f"{label.recording} {array.name}" if len(source.arrays) > 1 else label.recording
                yield label, Slide(name, t[use], rows[use, 1:], label.material, label.block or 0, label.speed)
