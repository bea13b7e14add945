"""Emulated device: a pseudo-terminal that sends packets on time, with faults on request.

Its bytes pass through the kernel's terminal like those of a real port; any program can open the other side.
"""

import contextlib
import fcntl
import os
import pty
import select
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from cnnsim.support import InputError
from tactile.serial.faults import Faults
from tactile.wire.base import Encoder
from tactile.wire.packets import TimedPacket

BUFFER = 64 * 1024
"""Buffer of the device in bytes; frames beyond it are dropped, as in firmware, and counted."""
BOOT = 0.3
"""[s] from the opening of the port to the first frame."""
PIECE_PAUSE = 0.0005
"""[s] Pause between the pieces of a split frame."""
AWAY = -1
"""File descriptor of an unplugged port."""
LINGER = 0.1
"""[s] Time the port stays open after the last byte."""


class Emulator:
    """One emulated device. ``port`` is the name to open; with a ``link`` it survives unplugging.

    ``device``: handles requests of the host, None if there are none. After `run`, ``sent`` is the number of packets
    sent or corrupted on purpose, ``lost`` the number of packets dropped because the buffer was full.

    Raises:
        InputError: the link cannot be made, or its name is taken; a dangling link of a killed emulator is replaced.
    """

    def __init__(
        self, faults: Faults | None = None, link: Path | None = None, device: Encoder | None = None, seed: int = 0
    ) -> None:
        self.sent = self.lost = self.unplugged = 0
        self._faults, self._link, self._device = faults or Faults(), link, device
        self._rng = np.random.default_rng(seed)
        self._pending = bytearray()
        self._plug()

    def _plug(self) -> None:
        self._master, slave = pty.openpty()
        tty.setraw(slave)  # no echo, no line editing
        os.set_blocking(self._master, False)
        self.port = self._terminal = os.ttyname(slave)
        os.close(slave)  # from here the master reports a hang-up while no program has the port open
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLHUP)
        if self._link is not None:
            try:
                if self._links_here(self._link) or (self._link.is_symlink() and not self._link.exists()):
                    self._link.unlink()
                self._link.symlink_to(self.port)
            except FileExistsError as error:
                os.close(self._master)
                raise InputError(f"link {self._link}: the name is taken; another name wanted") from error
            except OSError as error:
                os.close(self._master)
                raise InputError(f"link {self._link}: cannot be made: {error.strerror}") from error
            self.port = str(self._link)

    def _links_here(self, link: Path) -> bool:
        """Return whether the link belongs to this emulator, or is an old one to the same terminal."""
        return link.is_symlink() and str(link.readlink()) == self._terminal

    def pull(self) -> None:
        """Remove the port and its link."""
        if self._master == AWAY:
            return
        if self._link is not None and self._links_here(self._link):
            self._link.unlink()
        os.close(self._master)
        self._master = AWAY
        self._pending.clear()

    def run(
        self, packets: Iterable[TimedPacket], stop: threading.Event, opened: Callable[[], None] | None = None
    ) -> None:
        """Send every packet on time after the port was first opened, until they end or ``stop`` is set."""
        try:
            while not stop.is_set() and self._hung_up():
                stop.wait(0.01)
            if opened is not None:
                opened()
            stop.wait(BOOT)
            start, faults = time.monotonic(), self._faults
            for t, packet in packets:
                while not stop.is_set() and (wait := start + t - time.monotonic()) > 0:
                    self._serve(wait)
                if faults.in_spell(t, faults.unplug, faults.unplug_for):
                    self.pull()
                    continue
                if self._master == AWAY:
                    self.unplugged += 1
                    self._plug()
                while not stop.is_set() and faults.in_spell(time.monotonic() - start, faults.stall, faults.stall_for):
                    stop.wait(0.005)
                if stop.is_set():
                    return
                if self._was_asked(stop) and packet:
                    self._send(packet)
            self._flush(stop)
        finally:
            self.pull()

    def _hung_up(self) -> bool:
        """Return whether no program has the port open."""
        if self._master == AWAY:
            return True
        return any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def _serve(self, seconds: float) -> None:
        """Wait for a time while pending bytes are sent and requests are read."""
        if self._master == AWAY:
            time.sleep(min(seconds, 0.01))
            return
        wanted = [self._master] if self._pending else []
        said, room, _ = select.select([self._master], wanted, [], min(seconds, 0.05))
        if said and not self._receive():
            time.sleep(min(seconds, 0.01))  # a port that no program has open polls as ready: hang-up
        elif room:
            self._push()

    def _receive(self) -> bool:
        """Read requests of the host and answer; return whether there is a host."""
        try:
            said = os.read(self._master, 4096)
        except BlockingIOError:
            return True
        except OSError:
            return False
        if self._device is not None:
            self._pending += self._device.receive(said)
            self._push()
        return True

    def _push(self) -> None:
        """Write as many pending bytes as the terminal takes; without a host they are discarded."""
        if self._hung_up():  # the terminal would keep 64 KiB for the next program
            self._pending.clear()
        with contextlib.suppress(OSError):
            while self._pending:
                del self._pending[: os.write(self._master, self._pending)]

    def _was_asked(self, stop: threading.Event) -> bool:
        if self._device is None or not self._device.polled:
            return True
        while not stop.is_set() and not self._device.asked:
            self._serve(0.05)
        self._device.asked -= 1
        return not stop.is_set()

    def _send(self, packet: bytes) -> None:
        self.sent += 1
        for piece in self._faults.spoil(packet, self._rng):
            if len(self._pending) + len(piece) > BUFFER:
                self.lost += 1
                break
            self._pending += piece
            self._push()
            if self._faults.split:
                time.sleep(PIECE_PAUSE)

    def _flush(self, stop: threading.Event) -> None:
        """Wait until the host has read everything or closed the port, because closing discards the rest."""
        while not stop.is_set() and not self._hung_up() and (self._pending or self._unread()):
            self._serve(0.01)
            stop.wait(0.01)
        stop.wait(LINGER)

    def _unread(self) -> int:
        other = os.open(self._terminal, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            return int.from_bytes(fcntl.ioctl(other, termios.FIONREAD, bytes(4)), sys.byteorder)
        finally:
            os.close(other)
