# SPDX-License-Identifier: Apache-2.0
"""Images as arrays of height x width x 3 doubles, linear, row 0 on top."""
import struct
import zlib

import numpy as np

from failure import InputError

_EXR_LINES = {0: 1, 2: 1, 3: 16}  # compression: scan lines per chunk; none, ZIPS, ZIP
_EXR_TYPES = {1: np.dtype("<f2"), 2: np.dtype("<f4")}


def read(path):
    """PFM, or EXR of scan lines, uncompressed or ZIP; every value finite."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    if data[:2] in (b"PF", b"Pf"):
        decode = _decode_pfm
    elif data[:4] == b"\x76\x2f\x31\x01":
        decode = _decode_exr
    else:
        raise InputError(f"{path}: neither PFM nor EXR")
    try:
        image = decode(data)
    except (ValueError, IndexError, KeyError, struct.error, zlib.error) as error:
        raise InputError(f"{path}: damaged or not supported ({error})") from error
    if not np.isfinite(image).all():
        raise InputError(f"{path}: has a value that is not finite")
    return image


def write_pfm(path, image):
    """Little-endian floats, rows from the bottom to the top."""
    height, width, _ = image.shape
    with open(path, "wb") as file:
        file.write(f"PF\n{width} {height}\n-1.0\n".encode())
        file.write(np.ascontiguousarray(image[::-1], dtype="<f4").tobytes())


def _decode_pfm(data):
    magic, width, height, scale = data[:256].split(maxsplit=4)[:4]
    start = 0
    for word in (magic, width, height, scale):
        start = data.index(word, start) + len(word)
    width, height = int(width), int(height)
    channels = 3 if magic == b"PF" else 1
    kind = "<f4" if float(scale) < 0 else ">f4"
    values = np.frombuffer(data, kind, count=width * height * channels, offset=start + 1)
    image = values.reshape(height, width, channels)[::-1].astype(float)
    return np.repeat(image, 3, axis=2) if channels == 1 else image


def _exr_attributes(data):
    """Attributes by name, and where the header ends."""
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(0, at)
        kind_end = data.index(0, name_end + 1)
        (size,) = struct.unpack_from("<i", data, kind_end + 1)
        begin = kind_end + 5
        attributes[data[at:name_end].decode()] = data[begin:begin + size]
        at = begin + size
    return attributes, at + 1


def _exr_channels(data):
    """(name, type of its values) in the order of the file."""
    channels, at = [], 0
    while data[at]:
        end = data.index(0, at)
        kind, _, x_step, y_step = struct.unpack_from("<iB3xii", data, end + 1)
        if x_step != 1 or y_step != 1:
            raise ValueError("subsampled channels")
        channels.append((data[at:end].decode(), _EXR_TYPES[kind]))
        at = end + 17
    return channels


def _exr_unpack(chunk, size):
    """Undoes ZIP: deflate, then a running sum of bytes, then the two halves' bytes in turn."""
    if len(chunk) == size:
        return chunk  # stored, as it did not shrink
    values = np.frombuffer(zlib.decompress(chunk), np.uint8).astype(np.int64)
    values[1:] -= 128
    values = np.cumsum(values).astype(np.uint8)
    result = np.empty_like(values)
    half = (len(values) + 1) // 2
    result[0::2], result[1::2] = values[:half], values[half:]
    return result.tobytes()


def _decode_exr(data):
    if struct.unpack_from("<I", data, 4)[0] & 0x1A00:
        raise ValueError("tiles, deep data or several parts")
    attributes, at = _exr_attributes(data)
    compression = attributes["compression"][0]
    if compression not in _EXR_LINES:
        raise ValueError(f"compression {compression}; none, ZIPS and ZIP are known")
    channels = _exr_channels(attributes["channels"])
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    planes = {name: np.empty((height, width)) for name, _ in channels}
    line_size = width * sum(kind.itemsize for _, kind in channels)
    chunks = -(-height // _EXR_LINES[compression])
    for offset in struct.unpack_from(f"<{chunks}Q", data, at):
        first, size = struct.unpack_from("<ii", data, offset)
        first -= y0
        lines = min(_EXR_LINES[compression], height - first)
        raw = _exr_unpack(data[offset + 8:offset + 8 + size], lines * line_size)
        begin = 0
        for line in range(first, first + lines):
            for name, kind in channels:
                planes[name][line] = np.frombuffer(raw, kind, count=width, offset=begin)
                begin += width * kind.itemsize
    names = "RGB" if "R" in planes else "YYY"
    return np.stack([planes[name] for name in names], axis=2)
