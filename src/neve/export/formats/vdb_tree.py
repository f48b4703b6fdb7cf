"""OpenVDB files: grids as trees of 5, 4, 3 levels, written without a library.

File version 224, as OpenVDB reads it since version 4: a header, then for each grid its description, the
topology of its tree (root, nodes of 32^3, nodes of 16^3, leaves of 8^3 voxels), and the values of its leaves.
Of a leaf only the values of active voxels are written; all others are the background, 0.

Source: Museth 2013, "VDB: high-resolution sparse volumes with dynamic topology"; the layout of the file is
that of OpenVDB's reader [C], and is checked with it.
"""

from __future__ import annotations

import struct
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

LEAF, LOW, HIGH = 3, 4, 5
"""Base-two logarithms of the side of a leaf in voxels, of a node in leaves, and of a node in nodes."""
MAGIC, FILE_VERSION, LIBRARY = 0x56444220, 224, (10, 0)
ACTIVE_ALONE = 2
"""Flag of a grid's compression: of inactive voxels no value is written."""
ALL_OTHERS_BACKGROUND = b"\0"
"""Before the values of a node: all inactive ones are the background."""
_TYPES = {1: "float", 3: "vec3s"}


@dataclass(frozen=True)
class VdbGrid:
    """Hold a grid of numbers or vectors.

    name: of the grid. leaves (n, 3): voxel of the lowest corner of each leaf, a multiple of 8, each once.
    active (n, 8, 8, 8): whether a voxel is active. values (n, 8, 8, 8) or (n, 8, 8, 8, 3): float32
    size: edge of a voxel. first (3,): where voxel (0, 0, 0) has its centre
    facts: further metadata of the grid
    """

    name: str
    leaves: NDArray[np.int64]
    active: NDArray[np.bool_]
    values: NDArray[np.float32]
    size: float
    first: NDArray[np.float64]
    facts: Mapping[str, str | int]

    @property
    def width(self) -> int:
        """Numbers in a value."""
        return 3 if self.values.ndim == 5 else 1


def write_vdb(file: BinaryIO, grids: Sequence[VdbGrid], facts: Mapping[str, str | int]) -> None:
    """Write a file of `grids`; facts: metadata of the file."""
    content = struct.pack("<qIIIB", MAGIC, FILE_VERSION, *LIBRARY, 1)
    name = uuid.uuid5(uuid.NAMESPACE_OID, "neve")  # the same file for the same grids
    file.write(content + str(name).encode() + _metadata(facts) + struct.pack("<I", len(grids)))
    for grid in grids:
        _write_grid(file, grid)


def leaves_of(blocks: NDArray[Any], values: Sequence[NDArray[Any]]) -> tuple[NDArray[np.int64], list[Any]]:
    """Gather blocks of 4x4x4 voxels into leaves of 8x8x8; voxels of missing blocks are 0.

    blocks (b, 3); values: each (b, 4, 4, 4) or (b, 4, 4, 4, 3). Returns the lowest voxel of each leaf (n, 3),
    and the values of the leaves.
    """
    blocks = np.asarray(blocks, np.int64).reshape(-1, 3)
    places, row = np.unique(blocks >> 1, axis=0, return_inverse=True)
    row, part = row.reshape(-1), blocks & 1
    gathered = []
    for given in values:
        leaves = np.zeros((len(places), 2, 4, 2, 4, 2, 4, *given.shape[4:]), given.dtype)
        leaves[row, part[:, 0], :, part[:, 1], :, part[:, 2]] = given
        gathered.append(leaves.reshape(len(places), 8, 8, 8, *given.shape[4:]))
    return places << LEAF, gathered


def _write_grid(file: BinaryIO, grid: VdbGrid) -> None:
    """Write one grid: where its parts are, its description, its topology, its values."""
    order, nodes = _tree(grid.leaves)
    active = grid.active.reshape(len(grid.leaves), 8**3)
    masks = np.packbits(active, axis=1, bitorder="little")
    file.write(_text(grid.name) + _text(f"Tree_{_TYPES[grid.width]}_5_4_3") + _text(""))
    head = file.tell()
    file.write(bytes(24))
    start = file.tell()
    count = int(active.sum())
    facts: dict[str, str | int] = {"name": grid.name, "file_voxel_count": count, **grid.facts}
    file.write(struct.pack("<I", ACTIVE_ALONE) + _metadata(facts) + _transform(grid))
    file.write(struct.pack("<I", 1) + bytes(4 * grid.width) + struct.pack("<II", 0, len(nodes)))
    for origin, children in nodes:
        file.write(struct.pack("<3i", *origin) + _inner(HIGH, [slot for slot, _ in children]))
        for _, leaves in children:
            file.write(_inner(LOW, [slot for slot, _ in leaves]))
            file.write(masks[[row for _, row in leaves]].tobytes())
    middle = file.tell()
    flat = grid.values.reshape(len(grid.leaves), 8**3, grid.width)
    for row in order:
        file.write(masks[row].tobytes() + ALL_OTHERS_BACKGROUND)
        file.write(np.ascontiguousarray(flat[row][active[row]], "<f4").tobytes())
    end = file.tell()
    file.seek(head)
    file.write(struct.pack("<3q", start, middle, end))
    file.seek(end)


Leaves = list[tuple[int, int]]
Node = tuple[tuple[int, int, int], list[tuple[int, Leaves]]]


def _tree(leaves: NDArray[np.int64]) -> tuple[list[int], list[Node]]:
    """Return the rows of leaves in the order of the tree, and its nodes.

    A node of the upper level is its lowest voxel and, in the order of their slots, the nodes below: each a
    slot and its leaves, which are a slot and a row each.
    """
    top = leaves >> (LEAF + LOW + HIGH)
    middle = _slot((leaves >> (LEAF + LOW)) & (2**HIGH - 1), HIGH)
    low = _slot((leaves >> LEAF) & (2**LOW - 1), LOW)
    order = [int(row) for row in np.lexsort((low, middle, top[:, 2], top[:, 1], top[:, 0]))]
    nodes: list[Node] = []
    for row in order:
        x, y, z = (int(c) << (LEAF + LOW + HIGH) for c in top[row])
        if not nodes or nodes[-1][0] != (x, y, z):
            nodes.append(((x, y, z), []))
        children = nodes[-1][1]
        if not children or children[-1][0] != middle[row]:
            children.append((int(middle[row]), []))
        children[-1][1].append((int(low[row]), row))
    return order, nodes


def _slot(place: NDArray[np.int64], log: int) -> NDArray[np.int64]:
    """Return the slot of a child at (x, y, z) in a node of 2^log children a side: z runs fastest."""
    return np.asarray((place[:, 0] << 2 * log) | (place[:, 1] << log) | place[:, 2])


def _inner(log: int, slots: Sequence[int]) -> bytes:
    """Return a node without its children: which slots have one, that no other is active, no values."""
    bits = np.zeros(2 ** (3 * log), np.uint8)
    bits[list(slots)] = 1
    mask = np.packbits(bits, bitorder="little").tobytes()
    return mask + bytes(len(mask)) + ALL_OTHERS_BACKGROUND


def _transform(grid: VdbGrid) -> bytes:
    """Return the map from voxels to places: x = first + size i, with what follows from it."""
    s = grid.size
    each = [s, abs(s), 1.0 / s, 1.0 / s**2, 0.5 / s]
    numbers = [*(float(c) for c in grid.first), *(value for value in each for _ in range(3))]
    return _text("UniformScaleTranslateMap") + struct.pack(f"<{len(numbers)}d", *numbers)


def _metadata(facts: Mapping[str, str | int]) -> bytes:
    return struct.pack("<I", len(facts)) + b"".join(_fact(name, value) for name, value in facts.items())


def _fact(name: str, value: str | int) -> bytes:
    if isinstance(value, str):
        return _text(name) + _text("string") + _text(value)
    return _text(name) + _text("int64") + struct.pack("<Iq", 8, value)


def _text(text: str) -> bytes:
    data = text.encode()
    return struct.pack("<I", len(data)) + data
