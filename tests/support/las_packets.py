"""LAS 1.4 headers, points and waveform packets, read from the specification (ASPRS LAS 1.4 R16, LIDAR specification
11.3) with the struct module alone. Owes nothing to the writer under test, nor to any LAS library."""

import pathlib
import struct


class Las:
    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.raw = raw = self.path.read_bytes()
        assert raw[:4] == b"LASF", raw[:4]
        self.source_id, self.encoding = struct.unpack_from("<HH", raw, 4)
        self.guid = raw[8:24]
        self.version = raw[24], raw[25]
        self.system, self.software = (raw[at : at + 32].split(b"\0")[0].decode() for at in (26, 58))
        self.day, self.year, self.header_bytes, self.points_at, vlrs, self.format, self.record_bytes = (
            struct.unpack_from("<HHHIIBH", raw, 90)
        )
        self.legacy = struct.unpack_from("<6I", raw, 107)
        self.scale = struct.unpack_from("<3d", raw, 131)
        self.offset = struct.unpack_from("<3d", raw, 155)
        box = struct.unpack_from("<6d", raw, 179)
        self.high, self.low = box[0::2], box[1::2]
        self.packets_at, self.evlr_at, evlrs, self.count = struct.unpack_from("<QQIQ", raw, 227)
        self.by_return = struct.unpack_from("<15Q", raw, 255)
        self.vlrs, at = [], self.header_bytes
        for _ in range(vlrs):
            reserved, user, number, length, description = struct.unpack_from("<H16sHH32s", raw, at)
            assert reserved == 0
            self.vlrs.append((user.split(b"\0")[0].decode(), number, raw[at + 54 : at + 54 + length]))
            at += 54 + length
        self.vlrs_end = at
        self.evlrs, at = [], self.evlr_at
        for _ in range(evlrs):
            reserved, user, number, length, description = struct.unpack_from("<H16sHQ32s", raw, at)
            self.evlrs.append((user.split(b"\0")[0].decode(), number, at, length))
            at += 60 + length
        self.end = at if evlrs else self.points_at + self.count * self.record_bytes

    def vlr(self, user, number):
        found = [data for u, n, data in self.vlrs if (u, n) == (user, number)]
        assert len(found) == 1, (user, number, found)
        return found[0]

    def descriptor(self, index):
        """bits, compression, samples, spacing in ps, gain, offset of descriptor index 1 ..."""
        return struct.unpack("<BBIIdd", self.vlr("LASF_Spec", index + 99))

    def packet_store(self):
        """Bytes from the start of the 60-byte header on, to which packet offsets count."""
        if self.encoding & 2:
            return memoryview(self.raw)[self.packets_at :]
        assert self.encoding & 4
        return memoryview(self.path.with_suffix(".wdp").read_bytes())

    def point(self, number):
        """Fields of a point of format 6 or 9 as a dictionary; x, y, z in true coordinates."""
        at = self.points_at + number * self.record_bytes
        x, y, z, intensity, returns, flags, classification, user, angle, source, gps = struct.unpack_from(
            "<iiiHBBBBhHd", self.raw, at
        )
        out = dict(
            X=x,
            Y=y,
            Z=z,
            xyz=[v * s + o for v, s, o in zip((x, y, z), self.scale, self.offset)],
            intensity=intensity,
            return_number=returns & 15,
            number_of_returns=returns >> 4,
            flags=flags,
            classification=classification,
            user_data=user,
            scan_angle=angle,
            point_source_id=source,
            gps_time=gps,
        )
        if self.format == 9:
            index, offset, size, location, dx, dy, dz = struct.unpack_from("<BQIffff", self.raw, at + 30)
            out.update(index=index, offset=offset, size=size, location=location, direction=(dx, dy, dz))
        return out

    def extra(self, number):
        """The bytes after the point's own."""
        at = self.points_at + number * self.record_bytes
        return self.raw[at + {6: 30, 9: 59}[self.format] : at + self.record_bytes]

    def samples(self, store, index, offset, size):
        bits, compression, count, _, _, _ = self.descriptor(index)
        assert compression == 0 and size == count * bits // 8
        return struct.unpack_from(f"<{count}{'B' if bits == 8 else 'H'}", store, offset)


def place(point, spacing_ps, sample):
    """Where a sample lies: P + (L - sample spacing) d."""
    return [p + (point["location"] - sample * spacing_ps) * d for p, d in zip(point["xyz"], point["direction"])]
