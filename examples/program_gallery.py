"""Every program of the library on one sheet: what goes in (gray frame) and what comes out."""

import argparse
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from cnnsim import UniversalMachine, load_program
from tactile.elastic.halfspace import point_load_strain, point_load_stress

Planes = dict[str, NDArray[Any]]
READINGS = ("u_xz", "u_yz", "u_zz"), ("s_xz", "s_yz", "s_zz")  # strain, stress
SIGNED = {"divergence", "curl", "arrival", "shear_x", "shear_y", "dx", "dy", *READINGS[0], *READINGS[1]}
"""Drawn red (above 0) and blue."""
FROM_ZERO = {"gradient", "density", "force"}
COLUMNS = 4


def word(text: str, shape: tuple[int, int] = (26, 60)) -> NDArray[Any]:
    """Return thick black letters."""
    image = Image.new("L", shape[::-1], 0)
    ImageDraw.Draw(image).text((3, -5), text, fill=255, font=ImageFont.load_default(28), stroke_width=1)
    return np.asarray(image) > 128


def blobs(*places: tuple[int, int, int, int], shape: tuple[int, int] = (26, 60)) -> NDArray[Any]:
    """Return black rectangles (top, left, height, width)."""
    picture = np.zeros(shape, dtype=bool)
    for top, left, height, width in places:
        picture[top : top + height, left : left + width] = True
    return picture


def maze(rows: int, cols: int, rng: np.random.Generator) -> NDArray[Any]:
    """Carve a maze without loops: walk at random into rooms that are still closed, and back where there are none."""
    walls, stack = np.ones((2 * rows + 1, 2 * cols + 1), dtype=bool), [(1, 1)]
    walls[1, 1] = False
    while stack:
        i, j = stack[-1]
        near = [(i, j + 2), (i, j - 2), (i + 2, j), (i - 2, j)]
        closed = [(k, l) for k, l in near if 0 < k < 2 * rows and 0 < l < 2 * cols and walls[k, l]]
        if closed:
            k, l = closed[rng.integers(len(closed))]
            walls[(i + k) // 2, (j + l) // 2] = walls[k, l] = False
            stack.append((k, l))
        else:
            stack.pop()
    return walls


def readings() -> tuple[Planes, Planes]:
    """Return strain and stress at 16 x 16 taxels under a needle that presses and drags, 0.2 mm above them."""
    places = np.stack(np.meshgrid(*2 * [(np.arange(16) - 7.5) * 1e-4]), axis=-1)
    needle = [[3e-4, -2e-4, 0.01, 0.0, 0.05]]  # x, y [m], shear along x, y and pressing force [N]
    strain, stress = point_load_strain(places, 2e-4, needle, 2.4e6), point_load_stress(places, 2e-4, needle)
    found = [{key: field[..., k] for k, key in enumerate(keys)} for keys, field in zip(READINGS, (strain, stress),
             strict=True)]  # fmt: skip
    return found[0], found[1]


def scenes() -> list[tuple[str, list[Planes], str]]:
    """Return program, frames and the outputs to show."""
    rng = np.random.default_rng(4)
    letters = word("AB8")
    noisy = letters ^ (rng.random(letters.shape) < 0.02)
    objects = blobs((2, 2, 2, 2), (3, 8, 5, 5), (12, 3, 11, 11), (2, 18, 10, 10), (5, 21, 4, 4), (16, 20, 5, 6),
                    (2, 36, 20, 20), (5, 39, 14, 14), (9, 43, 6, 6), (23, 30, 2, 2))  # fmt: skip
    objects[5:9, 21:25] = objects[5:19, 39:53] = False
    objects[9:15, 43:49] = True
    i, j = np.indices((26, 60))
    gray = np.clip(np.cos(i / 6) * np.cos(j / 8) * 0.8, -1, 1)
    speckled = np.where(rng.random(gray.shape) < 0.06, rng.choice([-1.0, 1.0], gray.shape), gray)
    texture = np.where(j < 30, 0.2, 1.0) * rng.uniform(-0.9, 0.9, gray.shape)
    walls = maze(12, 29, rng)
    start, goal = blobs((1, 1, 1, 1), shape=walls.shape), blobs((23, 57, 1, 1), shape=walls.shape)
    looped = walls & (rng.random(walls.shape) < 0.9)
    looped[[0, -1]] = looped[:, [0, -1]] = True
    film = [
        {"frame": blobs((3, 5 + t, 6, 8), (14, 30, 8, 8), (3, 46 - 3 * t, 5, 5), (16 + t, 8, 5, 5))} for t in (0, 1)
    ]
    steps = [{"frame": blobs((3, 5 + t, 6, 8), (14, 30, 8, 8), (3, 46 - t, 5, 5), (16 + t, 8, 5, 5))} for t in (0, 1)]
    y, x = np.indices((16, 16)) - 7.5
    disc = x**2 + y**2 <= 40
    ring = (x**2 + y**2 < 36) & (x**2 + y**2 > 5)
    pressing = np.where(disc, 0.9, 0.0)
    drag, core = np.where(disc, 0.8, 0.0), np.where(x**2 + y**2 < 12, 0.8, 0.0)
    near_1, near_2 = (np.exp(-((x - c) ** 2 + (y - c) ** 2) / 8) / 2 for c in (-3.5, 3.5))
    field = {  # pulled apart in the upper left, twisted in the lower right
        "shear_x": (x + 3.5) * near_1 - (y - 3.5) * near_2,
        "shear_y": (y + 3.5) * near_1 + (x - 3.5) * near_2,
    }
    rough = np.where(disc, np.where(rng.random(disc.shape) < 0.85, 0.5, -0.5), 0.0)
    arch = disc & ~((abs(x) < 2) & (y > -3))
    spread = {"shear_x": 0.9 * pressing * np.sign(x), "shear_y": 0.9 * pressing * np.sign(y) * (abs(y) > 3)}
    strain, stress = readings()
    return [
        ("opening", [{"picture": noisy}], "opened"),
        ("closing", [{"picture": noisy}], "closed"),
        ("skeleton", [{"picture": letters}], "skeleton"),
        ("skeleton-4-connected", [{"picture": letters}], "skeleton"),
        ("thinning", [{"picture": letters}], "thin"),
        ("areas", [{"picture": letters}], "holes black hole_area"),
        ("euler-number", [{"picture": objects}], "starts euler"),
        ("count-objects", [{"picture": objects}], "objects"),
        ("count-holes", [{"picture": objects}], "holes"),
        ("count-runs", [{"picture": letters}], "rows columns"),
        ("size-sorting", [{"picture": objects}], "small medium large"),
        ("size-band-contour", [{"picture": objects}], "contour"),
        ("object-isolation", [{"picture": objects, "marker": blobs((10, 0, 5, 36))}], "chosen"),
        ("maze-path", [{"walls": walls, "ends": start | goal}], "path"),
        ("maze-shortest-path", [{"walls": looped, "start": start, "goal": goal}], "path length"),
        ("life", [{"picture": rng.random((26, 60)) < 0.3}], "alive"),
        ("gray-opening", [{"picture": speckled}], "eroded opened"),
        ("gray-closing", [{"picture": speckled}], "dilated closed"),
        ("gray-gradient", [{"picture": gray}], "gradient"),
        ("median", [{"picture": speckled}], "median"),
        ("rank-order", [{"picture": speckled}], "ranked"),
        ("halftone-and-back", [{"picture": gray}], "dots restored"),
        ("texture-segmentation", [{"picture": texture}], "density rough"),
        ("motion-detection", film, "moving resting"),
        ("motion-speed", film, "slow fast"),
        ("motion-direction", steps, "east west south rest"),
        ("contact-blob", [{"pressing": np.where(ring, 0.8, 0.0)}], "contact blob edge"),
        ("slip-front", [{"pressing": pressing, "shear_x": shear, "shear_y": 0 * drag} for shear in (drag, core)],
         "slid stuck front"),
        ("event-code", [{**spread, "pressing": pressing}], "x_plus x_minus y_plus y_minus contact moved"),
        ("comparators", [{"signal": field["shear_x"][None]}], "on"),
        ("locate-strain", [strain], "dx dy force"),
        ("locate-stress", [stress], "dx dy force"),
        ("shear-flow", [field], "divergence curl"),
        ("coherent-shear", [{"shear_x": rough, "shear_y": 0 * rough, "pressing": pressing}], "right left whole"),
        ("onset-wave", [{"contact": arch, "onset": blobs((11, 3, 1, 1), shape=(16, 16))}], "reached arrival"),
    ]  # fmt: skip


def main(output: Path) -> None:
    """Run every program on its scene and write the sheet to ``output``."""
    machine, sheet = UniversalMachine(), scenes()
    rows = -(-len(sheet) // COLUMNS)
    figure = plt.figure(figsize=(5 * COLUMNS, 1.85 * rows))
    for place, (name, frames, wanted) in enumerate(sheet):
        program = load_program(name)
        for frame in frames:
            out = machine.run(program, **frame)
        shown = [(key, out[key]) for key in wanted.split() if np.ndim(out[key])]
        numbers = [f"{key.replace('_', ' ')} {out[key]}" for key in wanted.split() if not np.ndim(out[key])]
        given = [(key, plane) for frame in frames for key, plane in frame.items() if plane.min() < plane.max()]
        left, bottom = place % COLUMNS / COLUMNS, 1 - (place // COLUMNS + 1) / rows
        figure.text(left + 0.005, bottom + 0.86 / rows, ": ".join([name, *[", ".join(numbers)] * bool(numbers)]),
                    fontsize=12, weight="bold", va="center")  # fmt: skip
        width = (1 / COLUMNS - 0.01) / max(2, len(given) + len(shown))
        for k, (title, plane) in enumerate([*given, *shown]):
            axes = figure.add_axes((left + 0.005 + k * width, bottom + 0.05 / rows, 0.96 * width, 0.62 / rows))
            draw(axes, title, plane, given=k < len(given), size=9 if len(given) + len(shown) < 8 else 7)
    figure.savefig(output, dpi=100)
    plt.close(figure)


def draw(axes: Any, title: str, plane: NDArray[Any], *, given: bool, size: float) -> None:
    """Draw one plane: black is +1, white -1; signed quantities in red and blue, densities from 0 up."""
    plane = plane.reshape(plane.shape[-2:])  # one of a batch
    values = np.where(plane, 1.0, -1.0) if plane.dtype == bool else plane
    most = float(np.nanmax(np.abs(values))) if title in SIGNED | FROM_ZERO else 1.0
    least = 0.0 if title in FROM_ZERO else -most
    axes.imshow(values, cmap="RdBu_r" if title in SIGNED else "gray_r", vmin=least, vmax=most, interpolation="nearest")
    axes.set(xticks=[], yticks=[], anchor="NW")
    axes.set_title(title.replace("_", " "), fontsize=size, loc="left", color="gray" if given else "black", pad=3)
    for edge in axes.spines.values():
        edge.set(color="silver" if given else "black", linewidth=3 if given else 1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("programs.png"), help="picture to write")
    main(parser.parse_args().output)
