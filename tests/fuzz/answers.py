"""The first lines of the reliability page: an answer for each part, and a figure of false frames by format."""

import re
from collections.abc import Mapping
from pathlib import Path

from matplotlib.figure import Figure

LEAST = 1e-5
"""Least share of the figure's axis."""


def rows(part: str) -> list[list[str]]:
    """Return the cells of the table of a part, without its titles."""
    lines = [line for line in part.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[1:]]


def answers(parts: Mapping[str, str]) -> str:
    """Return a list with a sentence or two for each part that is there."""
    lines = []
    if cable := rows(parts.get("False frames over a bad cable", "")):
        checked = [row for row in cable if row[0].startswith("native")]
        worst = max(cable, key=lambda row: float(row[5]))
        damaged, false = (sum(int(row[place]) for row in checked) for place in (2, 4))
        lines += [f"Cable: of {damaged} damaged packets of the native format, {false} became a false frame.",
                  f"A format without a checksum lets up to {worst[5]} of them through ({worst[0]})."]  # fmt: skip
    if random := rows(parts.get("Random bytes", "")):
        lines.append(f"Random bytes: {sum(int(row[2]) for row in random)} frames came out of {random[0][1]} a format.")
    if files := re.search(r"(\d+ changes of each of \d+ kinds of files.*)", parts.get("Broken files", "")):
        lines.append(f"Broken files: {files[1]}")
    if held := rows(parts.get("Frames held and lost", "")):
        lost = sum(int(row[4].split(",")[0]) for row in held)
        lines.append(f"Full rate: {lost} frames were lost, also next to four busy processes. "
                     f"{sum(row[-1] == 'yes' for row in held)} of {len(held)} runs held their rate.")  # fmt: skip
    if kills := re.search(r"(\d+) kills.*at most the last ([\d.]+ s) gone", parts.get("Kills", "")):
        lines.append(f"Kills: after {kills[1]} kills at most the last {kills[2]} of a recording were missing.")
    return "".join(f"- {line}\n" for line in lines)


def draw(part: str, path: Path) -> None:
    """Draw the share of damaged packets that became false frames, for each format."""
    found = {row[0]: float(row[5]) for row in rows(part)}
    figure = Figure(figsize=(8, 3.4), layout="constrained")
    axes = figure.add_subplot()
    names = [f"{name}: none" if not share else name for name, share in found.items()]
    axes.barh(names, [max(share, LEAST) - LEAST for share in found.values()], left=LEAST)
    axes.set(xscale="log", xlim=(LEAST, 1), xlabel="false frames a damaged packet")
    axes.tick_params(labelsize=8)
    axes.invert_yaxis()
    figure.savefig(path, dpi=90)
