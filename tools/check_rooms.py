#!/usr/bin/env python3
"""Checks who includes what: the order of the rooms, and third-party headers only where they belong.

Usage: tools/check_rooms.py [ROOT]. Prints one line "file:line: what is wrong" for each violation; ends with 1 if there
is one. The order (docs/architecture.md): base <- input, fem <- mesh <- io, linalg, fluid, beam, search <- coupling <-
fsi <- case; fluid may use linalg, fluid and beam never see each other, coupling sees neither.
"""
import fnmatch
import pathlib
import re
import sys

FOLDERS = {"libfbi": None, "meshgen": "meshgen", "post": "post", "tools": "tools"}

_MESH = ["base", "input", "fem", "mesh"]
_GENERATE = _MESH + ["io", "search", "case/schema.hpp"]
# What a room may include besides itself: rooms, or single headers.
MAY_INCLUDE = {
    "base": [],
    "input": ["base"],
    "fem": ["base"],
    "mesh": ["base", "input", "fem"],
    "io": _MESH,
    "linalg": _MESH,
    "fluid": _MESH + ["linalg"],
    "beam": _MESH,
    "search": _MESH,
    "coupling": _MESH + ["io", "linalg", "search"],
    "fsi": _MESH + ["io", "linalg", "fluid", "beam", "search", "coupling"],
    "case": _MESH + ["io", "linalg", "fluid", "beam", "search", "coupling", "fsi"],
    "meshgen": _GENERATE,
    "post": _GENERATE,
    # Programs: one library call; fbi-run ends PETSc before MPI.
    "tools": ["base", "io", "case", "meshgen", "post", "linalg/petsc.hpp"],
}
# The parameters of a room are plain structs: the schema of a case is put together from them.
PARAMETERS = {"case/schema.hpp", "case/schema_tables.hpp"}

# Third-party headers and the files that may include them.
ONLY_IN = {
    "HDF5": (["hdf5*.h", "H5*.h"], ["libfbi/io/*"]),
    "gmsh": (["gmsh*"], ["meshgen/gmsh_mesh.*"]),
    "VTK": (["vtk*"], ["post/vtk_export.*"]),
    "PETSc": (["petsc*"], ["libfbi/linalg/*", "libfbi/fluid/*", "libfbi/coupling/*", "libfbi/fsi/*", "libfbi/case/*"]),
    "SuiteSparse": (["cholmod*", "umfpack*", "suitesparse/*", "Eigen/CholmodSupport", "Eigen/UmfPackSupport"],
                    ["libfbi/linalg/*"]),
    "muParser": (["muParser*"], ["libfbi/input/*"]),
    "nlohmann-json": (["nlohmann/*"], ["libfbi/input/*"]),
    "CLI11": (["CLI/*"], ["tools/*"]),
}
# Headers that must not reach these third-party headers, not even through others.
FREE_OF = {
    "libfbi/case/schema*.hpp": ["MPI", "PETSc", "HDF5", "SuiteSparse"],
    "libfbi/*/parameters.hpp": ["MPI", "PETSc", "HDF5", "SuiteSparse"],
    "libfbi/beam/*.hpp": ["PETSc", "HDF5"],
    "libfbi/search/*.hpp": ["PETSc", "HDF5"],
    "libfbi/io/*.hpp": ["PETSc", "HDF5"],  # one .cpp knows HDF5, its users do not
    "meshgen/*.hpp": ["PETSc", "HDF5"],
    "post/*.hpp": ["PETSc", "HDF5"],
    "libfbi/fluid/physics.hpp": ["MPI", "PETSc"],
    "libfbi/fluid/hex8_*.hpp": ["MPI", "PETSc"],
    "libfbi/beam/torsion_free.hpp": ["MPI"],
}
THIRD_PARTY = {name: patterns for name, (patterns, _) in ONLY_IN.items()} | {"MPI": ["mpi.h"]}
GENERATED = {"revision.hpp"}

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')


def room_of(path):
    """Room of a source file, from its path below the root; None for files outside the rooms."""
    parts = pathlib.PurePosixPath(path).parts
    if parts[0] not in FOLDERS:
        return None
    return FOLDERS[parts[0]] or parts[1]


def find_sources(root):
    """{path below root: [(line, header, is_own)]} of all sources of the rooms."""
    sources = {}
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".hpp", ".cpp", ".h"):
                continue
            includes = []
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                match = INCLUDE.match(line)
                if match:
                    includes.append((number, match[1] or match[2], match[1] is not None))
            sources[file.relative_to(root).as_posix()] = includes
    return sources


def locate(header, sources):
    """The source that #include "header" names, as the build finds it; None if there is none."""
    for path in ("libfbi/" + header, header):
        if path in sources:
            return path
    return None


def matches(name, patterns):
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def reached(path, sources, cache):
    """{third-party name: chain of headers} that a source includes directly or through others."""
    if path in cache:
        return cache[path]
    cache[path] = found = {}
    for _, header, is_own in sources[path]:
        if is_own and locate(header, sources):
            target = locate(header, sources)
            for name, chain in reached(target, sources, cache).items():
                found.setdefault(name, [header] + chain)
        else:
            for name, patterns in THIRD_PARTY.items():
                if matches(header, patterns):
                    found.setdefault(name, [header])
    return found


def check(root):
    """All violations below `root`, as lines of text."""
    root = pathlib.Path(root)
    sources = find_sources(root)
    violations = []
    if not sources:
        return [f"{root}: no sources found"]
    for path, includes in sources.items():
        room = room_of(path)
        if room not in MAY_INCLUDE:
            violations.append(f"{path}:1: room {room} has no place in the order; add it to tools/check_rooms.py")
            continue
        for line, header, is_own in includes:
            where = f"{path}:{line}: "
            target = locate(header, sources) if is_own else None
            if is_own and target is None:
                if header not in GENERATED:
                    violations.append(where + f'"{header}" is not a file of the project; '
                                      'write "room/file.hpp", or <...> for others')
                continue
            if target:
                allowed = MAY_INCLUDE[room]
                other = room_of(target)
                if header in PARAMETERS:
                    fine = room == "case" or header in allowed or "case" in allowed
                else:
                    fine = other == room or other in allowed or header in allowed
                if not fine:
                    violations.append(where + f"{room} must not include {header} "
                                      f"(it may use: {', '.join(allowed) or 'nothing'})")
            for name, (patterns, files) in ONLY_IN.items():
                if not is_own and matches(header, patterns) and not matches(path, files):
                    violations.append(where + f"{name} is used in {', '.join(files)} only, not here: <{header}>")
    cache = {}
    for path in sources:
        for pattern, forbidden in FREE_OF.items():
            if not fnmatch.fnmatchcase(path, pattern):
                continue
            for name, chain in sorted(reached(path, sources, cache).items()):
                if name in forbidden:
                    violations.append(f"{path}:1: must stay free of {name}, but includes it: {' -> '.join(chain)}")
    return violations


def main(arguments):
    root = arguments[0] if arguments else pathlib.Path(__file__).resolve().parent.parent
    violations = check(root)
    for violation in violations:
        print(violation)
    print(f"{len(violations)} violation{'s' * (len(violations) != 1)} of the order of rooms")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
