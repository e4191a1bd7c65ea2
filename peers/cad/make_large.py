#!/usr/bin/env python3
"""A large STEP file: the entities of a file, repeated with other numbers, for the speed of reading.

    peers/cad/make_large.py FILE.step OUT.step [--size 40MB] [--check]

Every copy has all entities of the data section with its own numbers, so that its products are other products, and a number after the
name of each; the application context and its protocol are shared, as a file has one. `--check` reads the result with OpenCascade (needs
VENV of reference.py) and prints its faces and the seconds of reading.
"""

import argparse
import pathlib
import re
import sys
import time

UNITS = {"kB": 10**3, "MB": 10**6, "GB": 10**9}

# Comments and strings stay as they are; references get other numbers.
TOKENS = re.compile(rb"/\*.*?\*/|'(?:[^']|'')*'|\"[^\"]*\"|#(\d+)", re.DOTALL)
ENTITY = re.compile(rb"#(\d+)\s*=")
PRODUCT = re.compile(rb"(#\d+\s*=\s*PRODUCT\s*\(\s*'(?:[^']|'')*)('\s*,\s*'(?:[^']|'')*)(')", re.DOTALL)
SHARED = re.compile(rb"#\d+\s*=\s*APPLICATION_(CONTEXT|PROTOCOL_DEFINITION)\b")


def size_of(text):
    match = re.fullmatch(r"([\d.]+)(kB|MB|GB)", text)
    if not match:
        raise argparse.ArgumentTypeError(f"{text}: a number with kB, MB or GB is needed")
    return int(float(match[1]) * UNITS[match[2]])


def entities_of(data):
    """The texts of all entities: split at semicolons outside strings and comments."""
    result, start = [], 0
    for match in re.finditer(rb"/\*.*?\*/|'(?:[^']|'')*'|\"[^\"]*\"|;", data, re.DOTALL):
        if match[0] == b";":
            result.append(data[start:match.end()].strip())
            start = match.end()
    return result


def copy_of(text, number, step, shared):
    """An entity of the given copy: numbers moved by `number * step`, but for those of shared entities."""
    def move(match):
        if match[1] is None:
            return match[0]
        old = int(match[1])
        return b"#%d" % (old if old in shared else old + number * step)
    moved = TOKENS.sub(move, text)
    return PRODUCT.sub(rb"\g<1> %d\g<2> %d\g<3>" % (number, number), moved)


def write_large(source, out, size):
    """Returns the number of copies."""
    text = source.read_bytes()
    head, data = re.split(rb"\bDATA\s*;", text, maxsplit=1)
    data, tail = re.split(rb"\bENDSEC\s*;", data, maxsplit=1)
    if re.search(rb"\bDATA\s*[;(]", tail):
        raise ValueError(f"{source} has several data sections")
    entities = entities_of(data)
    step = 1 + max(int(ENTITY.search(entity)[1]) for entity in entities)
    shared = {int(ENTITY.search(entity)[1]) for entity in entities if SHARED.match(entity)}
    copies = 0
    with open(out, "wb") as file:
        written = file.write(head + b"DATA;\n")
        while written < size:
            for entity in entities:
                if not copies or int(ENTITY.search(entity)[1]) not in shared:
                    written += file.write(copy_of(entity, copies, step, shared) + b"\n")
            copies += 1
        file.write(b"ENDSEC;" + tail)
    return copies


def check(out):
    sys.path.append(str(pathlib.Path(__file__).resolve().parent))
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
    from step import explore
    start = time.perf_counter()
    reader = STEPControl_Reader()
    reader.ReadFile(str(out))
    parsed = time.perf_counter() - start
    roots = reader.TransferRoots()
    shape = reader.OneShape()
    faces, solids = (sum(1 for _ in explore(shape, kind)) for kind in (TopAbs_FACE, TopAbs_SOLID))
    seconds = time.perf_counter() - start
    print(f"OpenCascade: {roots} roots, {faces} faces, {solids} solids; parsed in {parsed:.2f} s, all in {seconds:.2f} s")


def main():
    parser = argparse.ArgumentParser(description="Repeats the entities of a STEP file until it is large.")
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--size", type=size_of, default=size_of("40MB"), help="least size, such as 40MB (10^6 bytes)")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    copies = write_large(arguments.source, arguments.out, arguments.size)
    print(f"{copies} copies, {arguments.out.stat().st_size / 1e6:.1f} MB")
    if arguments.check:
        check(arguments.out)


main()
