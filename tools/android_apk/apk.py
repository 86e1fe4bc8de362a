#!/usr/bin/env python3
"""What tools/android needs besides Cargo and Debian's Android tools.

    apk.py stubs RUST_LLD IMPORTS API FOLDER      shared libraries with nothing but the names that may be imported
    apk.py add APK OUT NAME=FILE...               a package with more files; what is mapped into memory stored and aligned
    apk.py verify APK IMPORTS API                 fails with every fault that is found, one a line

IMPORTS is a list of the system's functions that the app may call: `[LIBRARY]` lines, under them `SYMBOL [API]` lines with
the first API level that has it (none: all).
"""
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

# Devices with pages of 16 KiB map the library from the package as it lies there.
PAGE = 16384
# The record of alignment that apksigner keeps (apksigner's extra field).
ALIGNMENT_FIELD = 0xD935
LIBRARY = "lib/arm64-v8a/libontile.so"
AARCH64 = 183


def imports(path, api):
    """Library to names, those that this API level has."""
    libraries, names = {}, None
    for line in Path(path).read_text().splitlines():
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0].startswith("["):
            names = libraries.setdefault(words[0].strip("[]"), [])
        elif int(words[1] if len(words) > 1 else 0) <= api:
            names.append(words[0])
    return libraries


def stubs(lld, path, api, folder):
    for library, names in imports(path, int(api)).items():
        with tempfile.NamedTemporaryFile("w", suffix=".ld") as script:
            script.writelines(f'"{name}" = 0;\n' for name in names)
            script.flush()
            out = Path(folder) / f"{library}.so"
            command = [lld, "-flavor", "gnu", "-m", "aarch64linux", "-shared", "-z", f"max-page-size={PAGE}"]
            subprocess.run([*command, "-soname", out.name, "-o", out, script.name], check=True)


def alignment(name):
    return PAGE if name.endswith(".so") else 4


def add(apk, out, *files):
    with zipfile.ZipFile(apk) as old, zipfile.ZipFile(out, "w") as new:
        entries = [(entry.filename, old.read(entry)) for entry in old.infolist()]
        for name, path in (file.split("=", 1) for file in files):
            entries.append((name, Path(path).read_bytes()))
        for name, content in entries:
            # The same input gives the same bytes.
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            stored = name.endswith((".so", ".arsc", ".png", ".glb"))
            entry.compress_type = zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED
            if stored:
                align = alignment(name)
                start = new.fp.tell() + 30 + len(name.encode()) + 6
                padding = -start % align
                entry.extra = struct.pack("<HHH", ALIGNMENT_FIELD, 2 + padding, align) + bytes(padding)
            new.writestr(entry, content)


class Elf:
    """What the dynamic linker reads of a 64-bit little-endian library."""

    def __init__(self, content):
        self.content = content
        if content[:6] != b"\x7fELF\x02\x01":
            raise ValueError("is no 64-bit little-endian ELF")
        self.machine = self.read("<H", 18)[0]
        offset, size, count = *self.read("<Q", 32), *self.read("<HH", 54)
        self.segments = [self.read("<IIQQQQQQ", offset + i * size) for i in range(count)]

    def read(self, layout, offset):
        return struct.unpack_from(layout, self.content, offset)

    def offset_of(self, address):
        for kind, _, offset, start, _, in_file, *_ in self.segments:
            if kind == 1 and start <= address < start + in_file:
                return offset + address - start
        raise ValueError(f"has nothing at address {address:#x}")

    def dynamic(self):
        entries = {}
        for kind, _, offset, _, _, size, *_ in self.segments:
            if kind == 2:
                for at in range(offset, offset + size, 16):
                    tag, value = self.read("<QQ", at)
                    entries.setdefault(tag, []).append(value)
        return entries

    def text(self, at):
        return self.content[at : self.content.index(0, at)].decode()

    def load_alignments(self):
        return [segment[7] for segment in self.segments if segment[0] == 1]

    def names(self):
        """Libraries that are needed; symbols that are wanted of them; symbols that are offered."""
        dynamic = self.dynamic()
        strings, symbols = self.offset_of(dynamic[5][0]), self.offset_of(dynamic[6][0])
        needed = [self.text(strings + name) for name in dynamic.get(1, [])]
        # DT_HASH: its second word counts the symbols.
        count = self.read("<II", self.offset_of(dynamic[4][0]))[1]
        wanted, offered = set(), set()
        for i in range(1, count):
            name, _, _, section, *_ = self.read("<IBBHQQ", symbols + 24 * i)
            (offered if section else wanted).add(self.text(strings + name))
        return needed, wanted, offered


def library_faults(content, allowed):
    elf = Elf(content)
    if elf.machine != AARCH64:
        yield f"is for machine {elf.machine}, not AArch64"
    for align in elf.load_alignments():
        if align % PAGE:
            yield f"has a segment aligned to {align} bytes: link with -z max-page-size={PAGE}"
    needed, wanted, offered = elf.names()
    for library in needed:
        if library.removesuffix(".so") not in allowed:
            yield f"needs {library}, which no list of imports has"
    known = {name for names in allowed.values() for name in names}
    for name in sorted(wanted - known):
        yield f"imports {name}, which this API level has not, or imports.txt does not list"
    if "ANativeActivity_onCreate" not in offered:
        yield "does not export ANativeActivity_onCreate, which NativeActivity calls"


def faults(apk, allowed):
    with zipfile.ZipFile(apk) as package, open(apk, "rb") as raw:
        entries = {entry.filename: entry for entry in package.infolist()}
        for name in ["AndroidManifest.xml", "resources.arsc", LIBRARY]:
            if name not in entries:
                yield f"{name}: is missing"
        if not any(name.startswith("assets/") and name.endswith(".glb") for name in entries):
            yield "assets: no scene"
        for name, entry in entries.items():
            mapped = name.endswith((".so", ".arsc"))
            if mapped and entry.compress_type != zipfile.ZIP_STORED:
                yield f"{name}: is compressed, so it cannot be mapped"
            raw.seek(entry.header_offset + 26)
            start = entry.header_offset + 30 + sum(struct.unpack("<HH", raw.read(4)))
            if mapped and start % alignment(name):
                yield f"{name}: begins at {start}, not at a multiple of {alignment(name)}"
        if LIBRARY in entries:
            try:
                for fault in library_faults(package.read(LIBRARY), allowed):
                    yield f"{LIBRARY}: {fault}"
            except (ValueError, KeyError, struct.error) as error:
                yield f"{LIBRARY}: {error}"


def verify(apk, path, api):
    found = list(faults(apk, imports(path, int(api))))
    for fault in found:
        print(f"{apk}: {fault}", file=sys.stderr)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    commands = {"stubs": stubs, "add": add, "verify": verify}
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
