"""Tables of messages: one topic of an MCAP file (JSON or CDR) or of a ROS bag, a column for each field path.

Field paths are joined by dots: ``header.stamp`` [ns], ``data``, ``pillars.fX`` (one number of each message in a list).
``log_time`` [ns] is the time of recording.
"""

import json
from collections.abc import Iterable, Mapping
from io import BytesIO
from itertools import islice
from pathlib import Path
from typing import IO, Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.extras import need
from cnnsim.support.limits import one_line
from tactile.layout.table import EXTRA, Table, usable

MOST = 10**7
"""Largest number of messages."""


def read_messages(path: Path, layout: Any = None) -> Table:
    """Return the fields of the messages of one topic: that of the layout, or the only one, or the one with most."""
    topic = layout.topic if layout is not None else ""
    data = _json_messages(path, topic) if path.suffix.lower() == ".mcap" else None
    if data is None:
        from tactile.sources.replay_rosbag import table_of_bag  # imported when used

        data = BytesIO(table_of_bag(path.parent if path.suffix == ".db3" else path, topic))
    with one_line(path, "a table of messages"), np.load(data, allow_pickle=False) as file:
        columns, about = {name: file[name] for name in file.files if name != "about"}, json.loads(str(file["about"]))
    kept, left = usable(columns)
    others = ", ".join(f"{name} ({kind})" for name, kind in about["topics"].items() if name != about["topic"])
    notes = [f"other topics: {others}"] if others else []
    notes += [f"fields of unequal lengths: {', '.join(about['left'])}"] if about["left"] else []
    return Table(path, kept, (*notes, *left), about["topic"])


def pick_topic(topic: str, kinds: Mapping[str, str]) -> str:
    """Return the topic to read; ``kinds`` describes each one.

    Raises:
        ValueError: there is none, or not this one.
    """
    listed = ", ".join(f"{name} ({kind})" for name, kind in kinds.items())
    if not kinds or (topic and topic not in kinds):
        raise ValueError(f"topic {topic!r} wanted; it has {listed}" if kinds else "no messages in it")
    return topic or max(kinds, key=lambda name: int(kinds[name].split()[-2]))


def stacked(messages: Iterable[Mapping[str, Any]], topic: str, kinds: Mapping[str, str], out: IO[bytes]) -> None:
    """Write the fields of messages as arrays (messages, ...) in NPZ; those of unequal lengths are left out."""
    rows = [dict(_paths(message)) for message in islice(messages, MOST)]
    columns: dict[str, Any] = {}
    left = []
    for name in rows[0] if rows else ():
        try:
            array = np.array([row[name] for row in rows])
        except (KeyError, ValueError, OverflowError):
            left.append(name)
            continue
        columns[name] = array
    about = {"topic": topic, "topics": dict(kinds), "left": left}
    np.savez(out, about=np.array(json.dumps(about)), **{n: one for n, one in columns.items() if one.dtype.kind != "O"})


def _paths(value: Any, name: str = "") -> list[tuple[str, Any]]:
    """Return the numbers and texts in nested mappings and lists by their path."""
    if isinstance(value, Mapping):
        return [pair for key, one in value.items() for pair in _paths(one, f"{name}.{key}" if name else str(key))]
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        inside: dict[str, list[Any]] = {}
        for one in value:
            for path, item in _paths(one, name):
                inside.setdefault(path, []).append(item)
        return list(inside.items())
    return [(name, np.nan if value is None else value)]


def _json_messages(path: Path, topic: str) -> BytesIO | None:
    """Return the table of a topic of JSON messages; None for a file without them, which may be a ROS bag."""
    reader = need("mcap.reader", "an MCAP file", EXTRA)
    with one_line(path, "an MCAP file"), path.open("rb") as file:
        made = reader.make_reader(file)
        summary = made.get_summary()
        channels = [] if summary is None else list(summary.channels.values())
        counts = {} if summary is None or summary.statistics is None else summary.statistics.channel_message_counts
        told = [one for one in channels if one.message_encoding == "json"]
        encodings = sorted({one.message_encoding for one in channels})
        if not told and not ({"cdr", "ros1"} & set(encodings)):
            raise InputError(f"{path}: messages encoded as {', '.join(encodings) or 'nothing'}; json or cdr wanted")
        if not told or (topic in {one.topic for one in channels} - {one.topic for one in told}):
            return None
        kinds = {one.topic: f"json, {counts.get(one.id, 0)} messages" for one in told}
        name, out = pick_topic(topic, kinds), BytesIO()
        messages = made.iter_messages(topics=[name])
        rows = ({"log_time": message.log_time, **json.loads(message.data)} for _, _, message in messages)
        stacked(rows, name, kinds, out)
    out.seek(0)
    return out
