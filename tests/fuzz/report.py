"""Write docs/reliability.md: long runs, kills, unplugging, changed packets and files, false frames over a bad cable.

python -m tests.fuzz.report -o docs/reliability.md                  less than half an hour on two processors
python -m tests.fuzz.report --short -o docs/reliability.md          some minutes
python -m tests.fuzz.report --only Kills -o docs/reliability.md     this part only; the page keeps the others
"""

import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import click

from cnnsim.support.command_line import watched
from cnnsim.support.files import write_text
from tests.fuzz.answers import answers, draw
from tests.fuzz.cable import BURST, BYTE, judge
from tests.fuzz.hostile_files import hostile_files
from tests.fuzz.test_broken_files import NAMES
from tests.kits.wire import SHAPES, VARIANTS

RATES = {"native": 1000, "csv": 1000, "papillarray": 1000, "reskin": 400, "lowiek": 200, "paxini-fast": 91}
"""Frames a second that the devices of a format send."""
LIMITS = {
    "native": "CRC-16: misses one damaged packet in 65 536; every loss is counted",
    "csv": "without the checksum HH a changed digit is a valid number; a lost comma changes the number of columns",
    "csv, check": "8-bit checksum: misses one damaged line in 256, and two faults at the same bit position",
    "reskin": "no checksum, no counter: a changed number within 100 mT is a false frame; losses cannot be counted",
    "papillarray": "16-bit sum: changes can cancel; a jump of the counter is accepted when the next frame confirms it",
    "paxini-fast": "8-bit checksum: misses one damaged packet in 256; losses cannot be counted",
    "paxini-serial": "8-bit checksum: misses one damaged packet in 256; losses cannot be counted",
    "lowiek": "no checksum, no counter: a changed word is a false frame; a first and a last word of AAAA look the same",
}

SEE = (
    "Each bar is a format. Formats with a CRC or a sum let almost no damaged packet through, the others up to a third."
)
"""What the figure shows."""
ABOUT = {
    "False frames over a bad cable": f"""\
The cable: each byte with probability {BYTE:g} is changed in one bit (half of the faults), lost (a quarter) or followed
by one at random (a quarter); before each packet, with probability {BURST:g}, 1 to 40 bytes are lost. A frame is right
if its values and its counter equal those sent, in the order sent; otherwise it is false. The packets are those of small
arrays; a packet of n times as many bytes is damaged about n times as often.""",
    "Random bytes": "Noise at full rate, and streams of frames in which one byte in 500 is changed, lost or added.",
    "Broken files": """\
Each reader gets files truncated and changed by hypothesis, and files that unpack to gigabytes, declare huge sizes or
have deep nesting. The check fails on an exception other than the reader's own error, 5 s of processor time, a gigabyte
of memory, or, for recordings with checksums (MCAP, NPZ), a frame that was not written. Other formats may return changed
values.""",
    "Frames held and lost": """\
Frames pass through a pseudo-terminal while the pipeline runs and writes a recording. If the buffer is full, the device
drops a packet; formats with a counter report it as missing.""",
    "Kills": "The recorder is killed at random times; the frames on the disk are compared with the frames sent.",
    "Unplugging": "The port is removed and restored.",
}


def run(*words: str, **environment: str) -> tuple[bool, str]:
    """Run one of the long runs, and return whether its checks passed, and its output."""
    done = subprocess.run(
        [sys.executable, "-m", *words], capture_output=True, text=True, check=False, env=os.environ | environment
    )
    return done.returncode == 0, done.stdout if done.returncode == 0 else (done.stdout + done.stderr)


def rates(seconds: float) -> list[str]:
    """Return the table of frames held and lost by format, with one and with four busy processes."""
    lines = ["| format | frames/s sent | busy processes | frames read | lost, by the counters | latency 99 % | held |",
             "|---|---|---|---|---|---|---|"]  # fmt: skip
    for name, hz in watched(list(RATES.items()), "rates"):
        for others in (1, 4):
            good, said = run("tests.fuzz.endurance", "rate", "--protocol", name, "--hz", str(hz), "--seconds",
                             str(seconds), "--others", str(others))  # fmt: skip
            counts = {key: int(value) for key, value in re.findall(r"'(\w+)': (\d+)", said)}
            lost = sum(counts.get(key, 0) for key in ("missing", "bad_checksum", "unfit"))
            p99 = re.search(r"latency_p99_s': '([\d.]+ ms)", said)
            lines.append(
                f"| {name} | {hz} | {others} | {counts.get('good', 0)} | {lost}, {counts.get('overflowed', 0)} bytes |"
                f" {p99[1] if p99 else '-'} | {'yes' if good else 'no: ' + last_line(said)} |"
            )
    return lines


def cable(packets: int) -> list[str]:
    """Return the table of false frames."""
    lines = ["| format | packets | damaged | right frames | false frames | false frames a damaged packet | lost |"
             " lost, as counted | limit of the format |", "|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for name, extra in watched(VARIANTS, "cable"):
        found = judge(name, extra, packets)
        chosen = [value for value in extra.values() if value not in (False, [])]
        more = ", ".join("check" if value is True else str(value) for value in chosen)
        kind = f"{name}, check" if extra.get("check") else name
        part = found.false / max(1, found.damaged)
        lines.append(
            f"| {name}{f' ({more})' if more else ''} | {packets} | {found.damaged} | {found.right} | {found.false} |"
            f" {part:.2g} | {found.lost} | {found.said} | {LIMITS[kind]} |"
        )
    return lines


def random_bytes(count: int) -> list[str]:
    """Return the table of frames decoded from random and from changed bytes."""
    lines = ["| format | random bytes | false frames | as many bytes, one in 500 changed: frames, wrong frames |",
             "|---|---|---|---|"]  # fmt: skip
    for name in watched(list(SHAPES), "bytes"):
        good, said = run("tests.fuzz.endurance", "random", "--count", str(count), name)
        found = re.search(r"(\d+) false frames.*mutated: (\d+) frames, (\d+) wrong", said)
        lines.append(
            f"| {name} | {count} | {found[1]} | {found[2]}, {found[3]} |" if found and good
            else f"| {name} | {count} | failed | {last_line(said)} |"
        )  # fmt: skip
    return lines


def files(count: int) -> list[str]:
    """Return the result of changed and hostile files."""
    environment = {"FUZZ_EXAMPLES": str(count)}
    good, said = run("pytest", "tests/fuzz/test_broken_files.py", "-q", "-k", "changed or hostile", **environment)
    hostile = sum(1 for _ in hostile_files())
    if good:
        return [f"{count} changes of each of {len(NAMES)} kinds of files, and {hostile} hostile files: all passed."]
    return [f"failed: {line}" for line in said.splitlines() if line.startswith("FAILED")] or [last_line(said)]


def repeated(kind: str, times: int) -> list[str]:
    """Return the result of kills or of unplugging."""
    good, said = run("tests.fuzz.endurance", kind, "--times", str(times))
    return [said.strip() if good else f"failed: {last_line(said)}"]


def last_line(said: str) -> str:
    """Return the last line of a run's output."""
    return (said.strip().splitlines() or ["nothing said"])[-1][:200].replace("|", "/")


def machine() -> str:
    """Return the description of the machine."""
    info = Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*: (.*)", info.read_text(encoding="utf-8")) if info.exists() else []
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores, {platform.system()}, Python " + (
        platform.python_version()
    )


def section(title: str, make: Callable[[], list[str]]) -> str:
    """Return a section of the page, with the system load and the elapsed time."""
    begun, load = time.monotonic(), os.getloadavg()[0]
    lines = "\n".join(make())
    took = f"System load {load:.1f} at the start; {(time.monotonic() - begun) / 60:.1f} minutes."
    return (f"\n{ABOUT[title]}\n" if title in ABOUT else "") + f"\n{lines}\n\n{took}\n"


def sections(page: str) -> dict[str, str]:
    """Return the sections of a page by title, unchanged."""
    found = re.split(r"^## (.*)\n", page, flags=re.MULTILINE)
    return {title: text.rstrip("\n") + "\n" for title, text in zip(found[1::2], found[2::2], strict=True)}


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="The page.")
@click.option("--short", is_flag=True, help="A hundredth of the packets, bytes and files, short runs.")
@click.option("--seconds", type=float, default=60.0, show_default=True, help="Of each rate.")
@click.option("--kills", type=int, default=20, show_default=True)
@click.option("--unplugs", type=int, default=50, show_default=True)
@click.option("--packets", type=int, default=1_000_000, show_default=True, help="Of each decoder.")
@click.option("--count", type=int, default=3400, show_default=True, help="Changes of each file.")
@click.option("--only", multiple=True, type=click.Choice(list(ABOUT)), help="Parts to write; default: all.")
def main(
    output: Path, short: bool, seconds: float, kills: int, unplugs: int, packets: int, count: int, only: tuple[str, ...]
) -> None:  # fmt: skip
    """Write the page."""
    if short:
        seconds, kills, unplugs, packets, count = 5.0, 3, 3, packets // 100, count // 100
    makers: dict[str, Callable[[], list[str]]] = {
        "False frames over a bad cable": lambda: cable(packets),
        "Random bytes": lambda: random_bytes(packets),
        "Broken files": lambda: files(count),
        "Frames held and lost": lambda: rates(seconds),
        "Kills": lambda: repeated("kill", kills),
        "Unplugging": lambda: repeated("unplug", unplugs),
    }
    parts: dict[str, str] = sections(output.read_text(encoding="utf-8")) if only and output.exists() else {}
    for title, make in makers.items():
        if not only or title in only:
            parts[title] = section(title, make)
    write_text(output, page(parts, output, machine()))


def page(parts: dict[str, str], output: Path, where: str) -> str:
    """Return the page: the answers, a figure next to ``output``, and the parts."""
    text = f"# Reliability\n\n`make endurance` measures this page again. It ran on: {where}.\n\n{answers(parts)}"
    if cable_part := parts.get("False frames over a bad cable"):
        draw(cable_part, output.with_name(f"{output.stem}.png"))
        text += f"\n{SEE}\n\n![False frames a damaged packet, by format]({output.stem}.png)\n"
    return text + "".join(f"\n## {title}\n{parts[title]}" for title in ABOUT if title in parts)


if __name__ == "__main__":
    main()
