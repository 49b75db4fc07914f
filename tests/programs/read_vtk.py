"""Reads a .vtu or .vtp file by the VTK library (Debian: python3-vtk9) and prints its arrays as JSON.

Exits with 77 when there is no such library.
"""
import json
import sys

try:
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader
except ImportError:
    sys.exit(77)


def rows(array):
    return [array.GetTuple(i) for i in range(array.GetNumberOfTuples())]


def read(path):
    reader = vtkXMLPolyDataReader() if path.endswith(".vtp") else vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    arrays = {}
    for part in (data.GetPointData(), data.GetCellData(), data.GetFieldData()):
        for k in range(part.GetNumberOfArrays()):
            arrays[part.GetArrayName(k)] = rows(part.GetArray(k))
    cells = [[data.GetCell(c).GetPointId(k) for k in range(data.GetCell(c).GetNumberOfPoints())]
             for c in range(data.GetNumberOfCells())]
    return {"points": [data.GetPoint(i) for i in range(data.GetNumberOfPoints())], "cells": cells,
            "types": [data.GetCellType(c) for c in range(len(cells))], "arrays": arrays,
            "components": [data.GetPointData().GetArray("reynolds_stress").GetComponentName(c) for c in range(6)]
            if "reynolds_stress" in arrays else []}


json.dump(read(sys.argv[1]), sys.stdout)
