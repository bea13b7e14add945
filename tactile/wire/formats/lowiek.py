"""The LowiekVDS magnetic fingertip arrays (2 x 2, 4 x 8): one start byte and bare 16-bit words.

One frame, big endian: AA; then for every taxel x, y, z as u16, the bitwise complement of the magnetometer's word. No
checksum, sequence number or time, and AA may occur anywhere inside. A word stands for 0.150 uT (x, y) or 0.242 uT (z),
at gain 7 and resolution 0. The words wrap around: of the possible values, 2^16 apart, the one nearest to the previous
value is used. A jump of over 2^14 counts only if it lasts for three frames, so that one changed bit leaves no offset.
With option ``mode = "force"`` a word is a force instead: x, y from -10 to 10 N, z from -30 to 30 N.

Synchronisation needs five frames: of the offsets with AA five times at the distance of a frame, the one with the
smallest changes of the words is the phase, because out of phase low bytes become high ones. In phase, a frame with
small changes is accepted at once; one that jumps waits for the start byte of the next frame, or for five frames where
another phase has start bytes too. A lost byte thus costs one or two frames and no false wrap. Random bytes pass once in
2^40 offsets. A constant byte AA of a word looks like a start byte in every frame; the phase with smaller changes wins,
also later. A constant first word AAAA cannot be distinguished from a constant last one.

Source: High-Resolution-Three-axis-Force-Sensing-for-Robotic-Fingertips, ``sensor-readout/src/main.cpp``,
``notebooks/tools/sensor_reader.py``; the host there counts words from 0 to 65 535, here they have a sign.
"""

from collections.abc import Sequence

import numpy as np

from cnnsim.support import InputError, Integers
from tactile.wire.base import Decoder, Encoder, Found, Options
from tactile.wire.reading import Reading, Taxels
from tactile.wire.registry import Format

START = 0xAA
LSB = np.array([0.150, 0.150, 0.242])
SPAN = np.array([10.0, 10.0, 30.0])
PROOF, LAST_PROOF = 5, 3
"""Number of consecutive start bytes that make a phase, and at the end of the stream."""
LEAP, LASTING = 2**14, 3
"""Change of a word between frames that is doubted, and the number of frames that confirm it."""
SMOOTH = 2**11
"""Change of a word between frames below which no byte is lost (307 uT)."""
CLEAR = 2
"""Ratio of the changes of the words at which another phase replaces the present one."""


class LowiekDecoder(Decoder):
    """Decodes frames with the taxels of all boards."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._taxels, self._force = sum(options.taxels), force_mode(options)
        self._length = 1 + 6 * self._taxels
        self._restart()

    def _restart(self) -> None:
        self._in_step = False
        self._words: Integers | None = None  # of the last frame
        self._value: Integers | None = None  # what the words stood for when last believed
        self._doubted = np.zeros(3 * self._taxels, np.int64)
        self._past = b""  # the last frames in step

    def _next(self, over: bool) -> Found | None:
        if not self._in_step:
            return self._search(over)
        data, length = self._buffer, self._length
        if data[0] != START:
            return self._out_of_step(0)
        if len(data) < length:
            return None
        words = self._read(0)
        if self._words is not None and np.abs(_jump(words, self._words)).max() >= SMOOTH:
            if len(data) == length:
                return self._found(0, words) if over else None
            if data[length] != START:
                return self._out_of_step(1)
            if not over and self._rivalled():
                if len(data) < (PROOF + 1) * length - 1:
                    return None
                starts = self._starts(range(length), PROOF)
                if starts and (at := self._best(starts, PROOF)):
                    return self._out_of_step(at)
        self._past = self._past[-PROOF * length :] + bytes(data[:length])
        if data.find(START, 1, length) >= 0 and (better := self._better_phase()) is not None:
            self._words = self._value = None
            return self._out_of_step(better)
        return self._found(0, words)

    def _out_of_step(self, skip: int) -> Found:
        self._in_step, self._past = False, b""
        return Found(skip)

    def _rivalled(self) -> bool:
        """Return whether another phase can have a start byte in this frame and the available part of the next."""
        data, length = self._buffer, self._length
        at = data.find(START, 1, length)
        while at >= 0 and data[at + length : at + length + 1] not in (b"", bytes([START])):
            at = data.find(START, at + 1, length)
        return at >= 0

    def _better_phase(self) -> int | None:
        """Return the offset at which the last frames fit clearly better, None if there is none."""
        past, length = self._past, self._length
        if len(past) <= PROOF * length:
            return None
        starts = np.flatnonzero((np.frombuffer(past, np.uint8).reshape(-1, length) == START).all(0)).tolist()
        if len(starts) == 1:
            return None
        changes = {at: sum(_changes([self._words_in(past, at + n * length) for n in range(PROOF)])) for at in starts}
        best = min(starts, key=changes.__getitem__)
        return best if CLEAR * changes[best] < changes[0] else None

    def _search(self, over: bool) -> Found | None:
        """Find the phase and skip the bytes before it; at the end of the stream fewer frames suffice."""
        data, length = self._buffer, self._length
        proof = min(PROOF, len(data) // length) if over else PROOF
        starts = len(data) - proof * length + 1  # offsets from which ``proof`` frames fit
        alone = proof < LAST_PROOF and len(data) == proof * length  # a stream of a frame or two and nothing else
        if (starts < length and not over) or (over and proof < LAST_PROOF and not (proof and alone)):
            return None
        tries = range(min(length, starts))
        found = self._starts(tries, proof)
        if not found:
            return Found(len(tries))
        at = self._best(found, proof)
        self._in_step, self._past, self._words = True, b"", None  # the first frame is not doubted again
        return Found(at)

    def _starts(self, tries: range, proof: int) -> list[int]:
        """Return the offsets at which this many frames could begin."""
        data, length = self._buffer, self._length
        return [at for at in tries if all(data[at + n * length] == START for n in range(proof))]

    def _best(self, starts: list[int], proof: int) -> int:
        """Return the first offset whose words do not change clearly more than at another offset."""
        changes = [self._roughness(at, proof) for at in starts]
        return next(at for at, change in zip(starts, changes, strict=True) if change <= CLEAR * min(changes))

    def _roughness(self, at: int, proof: int) -> float:
        words = [self._read(at + n * self._length) for n in range(proof)]
        if self._words is None:
            return float(sum(_changes(words)))
        known = np.minimum(np.abs(_jump(words[0], self._words)), SMOOTH)  # that may have been a false frame
        return float(sum(_changes(words)) + known.sum())

    def _read(self, at: int) -> Integers:
        return self._words_in(self._buffer, at)

    def _words_in(self, data: bytes | bytearray, at: int) -> Integers:
        """Return the words as the magnetometers gave them, or as sent where they are forces."""
        sent = np.frombuffer(bytes(data[at + 1 : at + self._length]), ">u2")
        return (sent if self._force else ~sent).astype(np.int64)

    def _found(self, at: int, words: Integers) -> Found:
        if self._force:
            values = (words.reshape(-1, 3) / 65535 * 2 - 1) * SPAN
        else:
            values = self._unwrapped(words).reshape(-1, 3) * LSB
        self._words = words
        return Found(at, self._length, Reading(values, self._begin + at + self._length))

    def _unwrapped(self, words: Integers) -> Integers:
        if self._value is None:
            self._value = words.astype(np.int16).astype(np.int64)
        change = _jump(words, self._value)
        near = np.abs(change) < LEAP
        self._doubted = np.where(near, 0, self._doubted + 1)
        values = self._value + change
        self._value = np.where(near | (self._doubted >= LASTING), values, self._value)
        return values


class LowiekEncoder(Encoder):
    """Encodes frames; field values wrap as on the chips, forces are clipped."""

    def __init__(self, options: Options) -> None:
        self._force = force_mode(options)

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one frame with the taxels of all boards."""
        values = np.nan_to_num(np.concatenate(boards))
        if self._force:
            words = np.rint((np.clip(values / SPAN, -1, 1) + 1) / 2 * 65535).astype(np.int64)
        else:
            words = ~np.rint(values / LSB).astype(np.int64)
        return bytes([START]) + (words & 0xFFFF).astype(">u2").tobytes()


def force_mode(options: Options) -> bool:
    """Return the option: whether words are forces."""
    mode = options.extra.get("mode", "field")
    if mode not in ("field", "force"):
        raise InputError(f"lowiek: mode = {mode!r}, 'field' or 'force' wanted")
    return bool(mode == "force")


def _jump(now: Integers, before: Integers) -> Integers:
    """Return the change of words modulo 2^16, signed."""
    return (now - before + 2**15) % 2**16 - 2**15


def _changes(words: list[Integers]) -> list[int]:
    """Return the sum of changes of the words between frames."""
    return [int(np.abs(_jump(a, b)).sum()) for a, b in zip(words[1:], words, strict=False)]


FORMATS = {
    "lowiek": Format(
        "lowiek",
        "LowiekVDS magnetic fingertip arrays, 2 x 2 and 4 x 8",
        400000,
        1000.0,
        LowiekDecoder,
        LowiekEncoder,
        keys=("mode",),
        calibrated=force_mode,
    )
}
