# SPDX-License-Identifier: Apache-2.0
"""Drives that are made up from a seed, as labels or as images with a small network, and a look into their maps."""
import os
import random
import sqlite3
import struct
import zlib
from contextlib import closing

LINKS = 50_000  # of one file, as file systems allow


def field(number, value):
    """A field of a protocol buffer: a number, or bytes with their length."""
    if isinstance(value, int):
        return varint(number << 3) + varint(value)
    value = value.encode() if isinstance(value, str) else value
    return varint(number << 3 | 2) + varint(len(value)) + value


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out + bytes([value]))


def onnx(side, weights):
    """The mean color times `weights`, as probabilities."""

    def tensor_type(name, dimensions):
        shape = b"".join(field(1, field(1, size)) for size in dimensions)
        return field(1, name) + field(2, field(1, field(1, 1) + field(2, shape)))

    def node(kind, inputs, output, attribute=b""):
        return field(1, b"".join(field(1, name) for name in inputs) + field(2, output) + field(4, kind) + attribute)

    kernel = field(5, field(1, "kernel_shape") + field(8, 1) + field(8, 1) + field(20, 7))
    values = struct.pack(f"<{3 * len(weights)}f", *(weight for row in weights for weight in row))
    initializer = b"".join(field(1, size) for size in (len(weights), 3, 1, 1)) + field(2, 1) + field(8, "w")
    graph = (node("GlobalAveragePool", ["input"], "mean") + node("Conv", ["mean", "w"], "scores", kernel) +
             node("Flatten", ["scores"], "row") + node("Softmax", ["row"], "probabilities") + field(2, "small") +
             field(5, initializer + field(9, values)) + field(11, tensor_type("input", (1, 3, side, side))) +
             field(12, tensor_type("probabilities", (1, len(weights)))))
    return field(1, 5) + field(7, graph) + field(8, field(2, 10))


def png(color, noise, width=32, height=24):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(min(255, max(0, c + noise.randrange(-12, 13))) for _ in range(width) for c in color)
                    for _ in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


class Drive:
    """Through two hundred places, some minutes at each, as labels or images."""

    PLACES = 200
    STAY = 300  # frames

    def __init__(self, folder, seed):
        self.folder, self.random = folder, random.Random(seed)

    def places(self, frames):
        place = 0
        for _ in range(frames):
            if self.random.random() < 1 / self.STAY:
                place = self.random.randrange(self.PLACES)
            yield place

    def labels(self, frames):
        path, count = self.folder / "labels.csv", 24
        looks = []
        for _ in range(self.PLACES):
            scores = [self.random.random() ** 8 for _ in range(count)]
            looks.append([[score * self.random.uniform(0.8, 1.2) for score in scores] for _ in range(8)])
        texts = [[",".join(f"{s / sum(look):.4f}" for s in look) for look in place] for place in looks]
        with open(path, "w", encoding="utf-8") as file:
            file.write("image," + ",".join(f"thing {i}" for i in range(count)) + "\n")
            for i, place in enumerate(self.places(frames)):
                file.write(f"{i}.png,{texts[place][i % 8]}\n")
        return path

    def images(self, frames):
        path, originals = self.folder / "images", self.folder / "originals"
        path.mkdir()
        originals.mkdir()
        colors = [[self.random.randrange(20, 236) for _ in range(3)] for _ in range(self.PLACES)]
        copies = {}
        for i, place in enumerate(self.places(frames)):
            key = (place, i % 4, i // (LINKS * 4))
            if key not in copies:
                copies[key] = originals / "-".join(map(str, key))
                copies[key].write_bytes(png(colors[place], self.random))
            os.link(copies[key], path / f"{i:08}.png")
        return path

    def model(self):
        path, count = self.folder / "model", 24
        path.mkdir()
        weights = [[self.random.gauss(0, 8) for _ in range(3)] for _ in range(count)]
        (path / "small.onnx").write_bytes(onnx(8, weights))
        (path / "labels.txt").write_text("".join(f"thing {i}\n" for i in range(count)))
        (path / "model.toml").write_text('name = "small"\nfile = "small.onnx"\nlabels = "labels.txt"\ninput = 8\n'
                                         'color = "BGR"\nmean = 127.5\nscale = 0.00784\n')
        return path


def frames_of(path, mode="ro"):
    try:
        with closing(sqlite3.connect(f"file:{path}?mode={mode}", uri=True, timeout=1)) as database:
            return database.execute("SELECT ifnull(max(id) + 1, 0) FROM frames").fetchone()[0]
    except sqlite3.Error:
        return 0
