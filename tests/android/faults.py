"""faults.py APK FOLDER: copies of a package, each with one fault beside the lost signature; prints `FILE<tab>WHAT IS SAID` lines."""
import struct
import sys
import zipfile
from pathlib import Path

apk, folder = sys.argv[1], Path(sys.argv[2])
LIBRARY = "lib/arm64-v8a/libontile.so"
PAGE = 16384

with zipfile.ZipFile(apk) as package:
    whole = {entry.filename: package.read(entry) for entry in package.infolist()}


def write(name, entries, compressed=(), shift=0):
    path = folder / f"{name}.apk"
    with zipfile.ZipFile(path, "w") as package:
        for file, content in entries.items():
            entry = zipfile.ZipInfo(file, (1980, 1, 1, 0, 0, 0))
            stored = file.endswith((".so", ".arsc")) and file not in compressed
            entry.compress_type = zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED
            if stored:
                align = PAGE if file.endswith(".so") else 4
                start = package.fp.tell() + 30 + len(file) + 4
                padding = -start % align + (shift if file == LIBRARY else 0)
                entry.extra = struct.pack("<HH", 0xFFFF, padding) + bytes(padding)
            package.writestr(entry, content)
    return path


def library(old, new):
    assert old in whole[LIBRARY], old
    return whole | {LIBRARY: whole[LIBRARY].replace(old, new)}


def small_pages():
    content = bytearray(whole[LIBRARY])
    offset, (size, count) = struct.unpack_from("<Q", content, 32)[0], struct.unpack_from("<HH", content, 54)
    for i in range(count):
        if struct.unpack_from("<I", content, offset + i * size)[0] == 1:
            struct.pack_into("<Q", content, offset + i * size + 48, 4096)
    return whole | {LIBRARY: bytes(content)}


def without(name):
    return {file: content for file, content in whole.items() if file != name}


cases = [
    (write("unsigned", whole), "is not signed"),
    (write("compressed", whole, compressed=[LIBRARY]), "is compressed"),
    (write("misaligned", whole, shift=4096), "not at a multiple of 16384"),
    (write("small_pages", small_pages()), "a segment aligned to 4096"),
    (write("no_library", without(LIBRARY)), f"{LIBRARY}: is missing"),
    (write("no_resources", without("resources.arsc")), "resources.arsc: is missing"),
    (write("no_scene", {f: c for f, c in whole.items() if not f.startswith("assets/")}), "no scene"),
    (write("symbol", library(b"\0ALooper_pollOnce\0", b"\0ALooper_pollTwic\0")), "imports ALooper_pollTwic"),
    (write("needs", library(b"\0libandroid.so\0", b"\0libandroix.so\0")), "needs libandroix.so"),
    (write("entry", library(b"\0ANativeActivity_onCreate\0", b"\0ANativeActivity_onCreatf\0")), "does not export"),
    (write("another_processor", library(b"\x03\0\xb7\0", b"\x03\0\x3e\0")), "is for machine 62"),
    (write("api", whole | {"AndroidManifest.xml": whole["AndroidManifest.xml"].replace(struct.pack("<I", 30), struct.pack("<I", 29))}), "sdkVersion:'30'"),
    (write("vulkan", whole | {"AndroidManifest.xml": whole["AndroidManifest.xml"].replace(struct.pack("<I", 0x401000), struct.pack("<I", 0x400000))}), "android.hardware.vulkan.version"),
]
for path, said in cases:
    print(f"{path}\t{said}")
