"""ROS 2 bags of recordings, with standard messages only, for `ros2 bag play` and RViz."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from rosbags.rosbag2 import StoragePlugin, Writer

from cnnsim.support import InputError
from tactile.export.drawable import Message, typestore
from tactile.export.tared import new_folder

VERSION: Final = 8
"""Version of metadata.yaml, which Humble and later releases read."""


def write_ros2(folder: Path, messages: Iterable[Message]) -> int:
    """Write a ROS 2 bag (SQLite) with a topic for each of the messages' topics; return the number of messages.

    Raises:
        InputError: no messages; the name is taken, or the folder cannot be written.
    """
    with new_folder(folder) as made:
        made.rmdir()  # the library makes it
        topics, count = {}, 0
        with Writer(made, version=VERSION, storage_plugin=StoragePlugin.SQLITE3) as bag:
            for message in messages:
                if message.topic not in topics:
                    topics[message.topic] = bag.add_connection(message.topic, message.schema, typestore=typestore())
                bag.write(topics[message.topic], message.ns, message.data)
                count += 1
        if not count:
            raise InputError(f"{folder}: no frames to write, at least one wanted")
    return count
