"""What of a result that is being written can be read: the commits, in the file itself.

HDF5 changes the structure of a file by many small writes, between which it cannot be read, and a reader that opened it
before finds half of the changes later. So a result whose run is going on, or was killed, is not read through HDF5. After
each flush the writer adds a record to the file that says where in it the new numbers lie, and then sets one of two
slots, in turn, to the place of that record. Numbers and records are never changed once a slot leads to them: whoever has
read a slot can read all that it leads to, at any time, however the run goes on or ends. Records and slots bear checksums,
so that a slot that was read while it was written is recognised, and the other one taken. Nothing lies beside the file.

The last commit says that the run has ended. From then on the file is plain HDF5, as it is for any other program.

    the first block       magic word, two slots, records
    each further block    records
    slot                  number of commits, offset and length of the newest record, ended or not; checksum
    record                offset and length of the record before, 0 if there is none; checksum; JSON

Blocks are HDF5 datasets of bytes, /commits/block0000 … ; slots and records HDF5 does not know of. The system is trusted
to show the writes of a program in their order to the others: a file that several computers write and another one reads
is shown by some network file systems some seconds late.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import h5py

MAGIC = b"fsipetsc\x00commits"
_SLOT = struct.Struct("<QQQI")
_LINK = struct.Struct("<QQ")
_SUM = struct.Struct("<I")
_SLOT_BYTES = _SLOT.size + _SUM.size
_RECORDS = len(MAGIC) + 2 * _SLOT_BYTES  # where they begin in the first block
_SEARCHED = 16 << 10  # bytes at the beginning of a file, of which the first block begins in one
_LARGEST_BLOCK = 1 << 20


class Commit(NamedTuple):
    """A slot. number counts from 1."""

    number: int
    offset: int
    length: int
    ended: bool


class Log:
    """The commits of a file that is being written. Used by one process, while no other part of it has the file open."""

    def __init__(self) -> None:
        self._blocks = 0
        self._slots = 0  # place of the first slot
        self._at = self._end = 0  # what is free of the newest block
        self._newest = Commit(0, 0, 0, False)

    def room(self, file: h5py.File, entry: dict[str, Any]) -> bytes:
        """The record of an entry, for which there is room then: a block is added to the open file if there was none."""
        text = json.dumps(entry).encode()
        link = _LINK.pack(self._newest.offset, self._newest.length)
        record = link + _SUM.pack(zlib.crc32(link + text)) + text
        if self._at + len(record) > self._end:
            smallest = min(_LARGEST_BLOCK, 4096 << self._blocks)
            self._add_block(file, max(smallest, len(record) + (0 if self._blocks else _RECORDS)))
        return record

    def _add_block(self, file: h5py.File, size: int) -> None:
        properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        properties.set_layout(h5py.h5d.CONTIGUOUS)
        properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        group = file.require_group("commits")
        name = f"block{self._blocks:04d}".encode()
        block = h5py.h5d.create(group.id, name, h5py.h5t.NATIVE_UINT8, h5py.h5s.create_simple((size,)), properties)
        self._at = block.get_offset()
        self._end = self._at + size
        if not self._blocks:
            self._slots = self._at + len(MAGIC)
            self._at += _RECORDS
        self._blocks += 1

    def commit(self, record: bytes, write: Callable[[bytes, int], None]) -> None:
        """Make a record, and with it all that it tells of, the newest. write(data, offset) writes to the file."""
        write(record, self._at)
        self._newest = Commit(self._newest.number + 1, self._at, len(record), False)
        self._at += len(record)
        if self._newest.number == 1:
            write(MAGIC, self._slots - len(MAGIC))
        write(_slot(self._newest), self._slots + self._newest.number % 2 * _SLOT_BYTES)

    def end(self, write: Callable[[bytes, int], None]) -> None:
        """Say that the run has ended, and the file is as HDF5 says."""
        self._newest = self._newest._replace(number=self._newest.number + 1, ended=True)
        for place in (self._newest.number % 2, 1 - self._newest.number % 2):  # first where the older one stands
            write(_slot(self._newest), self._slots + place * _SLOT_BYTES)


def _slot(commit: Commit) -> bytes:
    packed = _SLOT.pack(*commit)
    return packed + _SUM.pack(zlib.crc32(packed))


def newest(descriptor: int) -> Commit | None:
    """The newest commit of an open file; None if there are no commits in it. Raises ValueError if none is whole."""
    head = os.pread(descriptor, _SEARCHED, 0)
    place = head.find(MAGIC)
    if place < 0:
        return None
    commits = []
    for k in range(2):
        slot = os.pread(descriptor, _SLOT_BYTES, place + len(MAGIC) + k * _SLOT_BYTES)
        packed, check = slot[: _SLOT.size], slot[_SLOT.size :]
        if len(check) == _SUM.size and _SUM.unpack(check)[0] == zlib.crc32(packed):
            number, offset, length, ended = _SLOT.unpack(packed)
            commits.append(Commit(number, offset, length, bool(ended)))
    if not commits:
        raise ValueError("neither of the two places that tell what has been written is whole")
    return max(commits)


def entries(descriptor: int, commit: Commit) -> list[dict[str, Any]]:
    """What was committed, from the first entry to that of `commit`. Raises ValueError if one is not whole."""

    def backwards() -> Iterator[dict[str, Any]]:
        offset, length = commit.offset, commit.length
        for _ in range(commit.number):
            record = os.pread(descriptor, length, offset) if length < 1 << 31 else b""
            text = record[_LINK.size + _SUM.size :]
            if len(record) < max(length, _LINK.size + _SUM.size):
                raise ValueError("ends before what it says has been written")
            if _SUM.unpack_from(record, _LINK.size)[0] != zlib.crc32(record[: _LINK.size] + text):
                raise ValueError("a record of what has been written is damaged")
            yield json.loads(text)
            offset, length = _LINK.unpack_from(record)
            if not length:
                return
        raise ValueError("the records of what has been written do not end")

    return list(backwards())[::-1]
