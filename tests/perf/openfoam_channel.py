"""The flow of a case's channel by OpenFOAM's icoFoam, to compare times with: PISO, two correctors, implicit Euler,
linear-upwind convection, multigrid for the pressure. Fluid only; the same grid, time step, inflow and walls.

OpenFOAM is optional: Debian's package `openfoam` (1912) is what this was written for.
"""
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import time

NEEDED = ["icoFoam", "blockMesh", "decomposePar"]
ROOT_OF_DEBIAN = "/usr/share/openfoam"


def is_installed():
    return all(shutil.which(name) for name in NEEDED)


def _entries(values, indent=0):
    """A dictionary in OpenFOAM's notation; text is written as it is."""
    text, pad = "", "    " * indent
    for key, value in values.items():
        if isinstance(value, dict):
            text += f"{pad}{key}\n{pad}{{\n{_entries(value, indent + 1)}{pad}}}\n"
        else:
            text += f"{pad}{key} {value};\n"
    return text


def _write(folder, name, kind, values):
    header = {"version": "2.0", "format": "ascii", "class": kind, "object": pathlib.Path(name).name}
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(_entries({"FoamFile": header, **values}))


def write_case(folder, size, cells, viscosity, dt, steps, inflow, ranks):
    """A channel from (0, 0, 0) to `size`; `inflow` is the function u(y) at x = 0, sampled at the cell centers."""
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    corners = [(x, y, z) for z in (0, size[2]) for y in (0, size[1]) for x in (0, size[0])]
    corners = [corners[i] for i in (0, 1, 3, 2, 4, 5, 7, 6)]
    sides = {"inlet": ("patch", "0 4 7 3"), "outlet": ("patch", "1 2 6 5"), "floor": ("wall", "0 1 5 4"),
             "top": ("patch", "3 7 6 2"), "sides": ("patch", "0 3 2 1) (4 5 6 7")}
    triple = lambda v: "(" + " ".join(f"{x:.12g}" for x in v) + ")"
    _write(folder, "system/blockMeshDict", "dictionary", {
        "convertToMeters": "1",
        "vertices": "(" + " ".join(triple(c) for c in corners) + ")",
        "blocks": f"(hex (0 1 2 3 4 5 6 7) {triple(cells)} simpleGrading (1 1 1))",
        "edges": "()",
        "boundary": "(" + "".join(f"\n{name} {{ type {kind}; faces (({faces})); }}"
                                  for name, (kind, faces) in sides.items()) + "\n)",
    })
    _write(folder, "system/controlDict", "dictionary", {
        "application": "icoFoam", "startFrom": "startTime", "startTime": "0", "stopAt": "endTime",
        "endTime": f"{dt * (steps + 0.5):.12g}", "deltaT": f"{dt:.12g}", "writeControl": "timeStep",
        "writeInterval": str(10 * steps), "writePrecision": "10", "timePrecision": "10", "runTimeModifiable": "no"})
    _write(folder, "system/fvSchemes", "dictionary", {
        "ddtSchemes": {"default": "Euler"},
        "gradSchemes": {"default": "Gauss linear"},
        "divSchemes": {"default": "none", "div(phi,U)": "Gauss linearUpwind default"},
        "laplacianSchemes": {"default": "Gauss linear orthogonal"},
        "interpolationSchemes": {"default": "linear"},
        "snGradSchemes": {"default": "orthogonal"}})
    pressure = {"solver": "GAMG", "smoother": "GaussSeidel", "tolerance": "1e-6"}
    _write(folder, "system/fvSolution", "dictionary", {
        "solvers": {"p": {**pressure, "relTol": "0.01"}, "pFinal": {**pressure, "relTol": "0"},
                    "U": {"solver": "smoothSolver", "smoother": "symGaussSeidel", "tolerance": "1e-6", "relTol": "0"}},
        "PISO": {"nCorrectors": "2", "nNonOrthogonalCorrectors": "0", "pRefCell": "0", "pRefValue": "0"}})
    cut = max(range(3), key=lambda d: cells[d])
    parts = [ranks if d == cut else 1 for d in range(3)]
    _write(folder, "system/decomposeParDict", "dictionary", {
        "numberOfSubdomains": str(ranks), "method": "simple", "coeffs": {"n": triple(parts), "delta": "0.001"}})
    _write(folder, "constant/transportProperties", "dictionary", {"nu": f"[0 2 -1 0 0 0 0] {viscosity:.12g}"})
    h = size[1] / cells[1]
    table = " ".join(f"({(j + 0.5) * h:.12g} ({inflow((j + 0.5) * h):.12g} 0 0))" for j in range(cells[1]))
    zero_gradient, slip = {"type": "zeroGradient"}, {"type": "slip"}
    _write(folder, "0/U", "volVectorField", {
        "dimensions": "[0 1 -1 0 0 0 0]", "internalField": "uniform (0 0 0)",
        "boundaryField": {
            "inlet": {"type": "fixedProfile", "profile": f"table ({table})", "direction": "(0 1 0)", "origin": "0",
                      "value": "uniform (0 0 0)"},
            "outlet": zero_gradient, "floor": {"type": "noSlip"}, "top": slip, "sides": slip}})
    _write(folder, "0/p", "volScalarField", {
        "dimensions": "[0 2 -2 0 0 0 0]", "internalField": "uniform 0",
        "boundaryField": {"inlet": zero_gradient, "outlet": {"type": "fixedValue", "value": "uniform 0"},
                          "floor": zero_gradient, "top": zero_gradient, "sides": zero_gradient}})


def run(folder, ranks, launch):
    """Runs the case; `launch` is the command of MPI. Returns icoFoam's log and the wall time of each step."""
    folder = pathlib.Path(folder)
    environment = dict(os.environ)
    if "WM_PROJECT_DIR" not in environment and os.path.isdir(ROOT_OF_DEBIAN):
        environment["WM_PROJECT_DIR"] = ROOT_OF_DEBIAN

    def call(command):
        log = folder / f"log.{command[len(launch)] if command[0] == launch[0] else command[0]}"
        ends = []  # of the steps: when the line with their times came (its numbers are in hundredths and whole seconds)
        with open(log, "w") as out, subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True,
                                                     stderr=subprocess.STDOUT, env=environment) as process:
            for line in process.stdout:
                out.write(line)
                if line.startswith("Time = ") and not ends or line.startswith("ExecutionTime = "):
                    ends.append(time.monotonic())
        if process.returncode != 0:
            raise RuntimeError(f"{log.suffix[1:]} ended with {process.returncode}, see {log}")
        return log.read_text(), [b - a for a, b in zip(ends, ends[1:])]

    call(["blockMesh"])
    if ranks > 1:
        call(["decomposePar"])
    return call(launch + ["icoFoam", "-parallel"] if ranks > 1 else ["icoFoam"])


def pressure_iterations(log):
    return statistics.mean(int(n) for n in re.findall(r"Solving for p,.*No Iterations ([0-9]+)", log))
