"""Pages of the site that are made from notebooks, with the outputs that the notebooks keep."""

import json
from base64 import b64decode
from collections.abc import Callable
from pathlib import Path
from typing import Any


def write_notebooks(notebooks: Path, folder: Path, relinked: Callable[[str, Path, Path], str]) -> None:
    """Write a page for each notebook, and its pictures; ``relinked`` corrects links (text, from, to)."""
    folder.mkdir()
    for path in sorted(notebooks.glob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        parts = []
        for number, cell in enumerate(cells):
            source = "".join(cell["source"])
            if cell["cell_type"] == "markdown":
                parts.append(relinked(source, notebooks, folder))
                continue
            parts.append(f"```python\n{source}\n```")
            for count, output in enumerate(cell["outputs"]):
                parts.append(_output(output, folder / f"{path.stem}-{number}-{count}.png"))
        parts.append(f"The notebook is `examples/notebooks/{path.name}`.\n")
        (folder / f"{path.stem}.md").write_text("\n\n".join(parts), encoding="utf-8")


def _output(output: dict[str, Any], picture: Path) -> str:
    """Return the Markdown of an output: a picture, HTML or text."""
    data = output.get("data", {})
    if "image/png" in data:
        picture.write_bytes(b64decode(data["image/png"]))
        return f"![Output of the cell]({picture.name})"
    if "text/html" in data:
        html = "".join(data["text/html"])
        return f"```{{raw}} html\n{html}\n```"
    text = "".join(output.get("text", data.get("text/plain", "")))
    return f"```text\n{text.rstrip()}\n```"
