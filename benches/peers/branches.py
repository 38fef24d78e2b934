"""VMTK's centerlines, branches and angles of a model, as the tests of `ramus analyze` compare with.

    target/peers/vmtk/bin/python benches/peers/branches.py MODEL.ply TRUTH.seeds.json STEP OUT

writes OUT.vtp, the lines in steps of STEP (0: as they are), and OUT.json: what VMTK's filters make of these lines.
"""

import json
import sys
from pathlib import Path

import vtk
from vmtk import vtkvmtk, vmtkscripts

RADIUS = "MaximumInscribedSphereRadius"
CELLS = {"Blanking": "Blanking", "GroupIds": "GroupIds", "TractIds": "TractIds", "CenterlineIds": "CenterlineIds"}
MEASURES = ["Length", "Curvature", "Torsion", "Tortuosity"]


def surface(path):
    readers = {".vtp": vtk.vtkXMLPolyDataReader, ".stl": vtk.vtkSTLReader, ".obj": vtk.vtkOBJReader, ".ply": vtk.vtkPLYReader}
    reader = readers[Path(path).suffix]()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def name(filter, names):
    for what, value in names.items():
        getattr(filter, f"Set{what}ArrayName")(value)


def rows(data, arrays):
    arrays = {array: data.GetArray(array) for array in arrays}
    first = next(iter(arrays.values()))
    row = lambda place: {array: value.GetTuple(place) if value.GetNumberOfComponents() > 1 else value.GetValue(place) for array, value in arrays.items()}
    return [row(place) for place in range(first.GetNumberOfTuples())]


def rounded(what):
    """Seven digits are as many as the points have."""
    if isinstance(what, float):
        return float(f"{what:.7g}")
    if isinstance(what, dict):
        return {key: rounded(value) for key, value in what.items()}
    return [rounded(value) for value in what] if isinstance(what, (list, tuple)) else what


def found(model, seeds, step=0):
    """VMTK's lines of a surface, with nothing but their radii."""
    find = vmtkscripts.vmtkCenterlines()
    find.Surface, find.SeedSelectorName, find.AppendEndPoints = model, "pointlist", 0
    if step > 0:
        find.Resampling, find.ResamplingStepLength = 1, step
    find.SourcePoints = list(seeds["source"])
    find.TargetPoints = [number for target in seeds["targets"] for number in target]
    find.Execute()
    lines = vtk.vtkPolyData()
    lines.SetPoints(find.Centerlines.GetPoints())
    lines.SetLines(find.Centerlines.GetLines())
    lines.GetPointData().AddArray(find.Centerlines.GetPointData().GetArray(RADIUS))
    return lines


def written(lines, path):
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(path)
    writer.SetInputData(lines)
    writer.Write()


def branches(lines):
    """Lines cut into branches, what is measured of them, and the bifurcations' reference systems and vectors."""
    split = vtkvmtk.vtkvmtkCenterlineBranchExtractor()
    split.SetInputData(lines)
    split.SetRadiusArrayName(RADIUS)
    name(split, CELLS)
    split.SetGroupingModeToPointInTube()
    split.Update()
    parts = split.GetOutput()
    geometry = vtkvmtk.vtkvmtkCenterlineBranchGeometry()
    geometry.SetInputData(parts)
    geometry.SetRadiusArrayName(RADIUS)
    geometry.SetGroupIdsArrayName("GroupIds")
    geometry.SetBlankingArrayName("Blanking")
    name(geometry, {measure: measure for measure in MEASURES})
    geometry.SetLineSmoothing(0)
    geometry.Update()
    frames = vtkvmtk.vtkvmtkCenterlineBifurcationReferenceSystems()
    frames.SetInputData(parts)
    frames.SetRadiusArrayName(RADIUS)
    frames.SetGroupIdsArrayName("GroupIds")
    frames.SetBlankingArrayName("Blanking")
    frames.SetNormalArrayName("Normal")
    frames.SetUpNormalArrayName("UpNormal")
    frames.Update()
    vectors = vtkvmtk.vtkvmtkCenterlineBifurcationVectors()
    vectors.SetInputData(parts)
    vectors.SetReferenceSystems(frames.GetOutput())
    vectors.SetRadiusArrayName(RADIUS)
    name(vectors, CELLS)
    vectors.SetReferenceSystemGroupIdsArrayName("GroupIds")
    vectors.SetReferenceSystemNormalArrayName("Normal")
    vectors.SetReferenceSystemUpNormalArrayName("UpNormal")
    vectors.SetNormalizeBifurcationVectors(0)
    arrays = {
        "BifurcationVectors": "Vector",
        "InPlaneBifurcationVectors": "InPlane",
        "OutOfPlaneBifurcationVectors": "OutOfPlane",
        "InPlaneBifurcationVectorAngles": "InPlaneAngle",
        "OutOfPlaneBifurcationVectorAngles": "OutOfPlaneAngle",
        "BifurcationVectorsOrientation": "Orientation",
        "BifurcationGroupIds": "BifurcationGroupIds",
    }
    name(vectors, arrays)
    vectors.Update()
    return parts, geometry.GetOutput(), frames.GetOutput(), vectors.GetOutput()


def main():
    model, seeds, step, out = sys.argv[1], json.load(open(sys.argv[2])), float(sys.argv[3]), sys.argv[4]
    lines = found(surface(model), seeds, step)
    written(lines, out + ".vtp")
    parts, geometry, frames, vectors = branches(lines)
    told = {"tracts": rows(parts.GetCellData(), list(CELLS))}
    for place, tract in enumerate(told["tracts"]):
        cell = parts.GetCell(place)
        points = [cell.GetPoints().GetPoint(at) for at in range(cell.GetNumberOfPoints())]
        tract["first"], tract["last"] = points[0], points[-1]
        tract["length"] = sum(vtk.vtkMath.Distance2BetweenPoints(a, b) ** 0.5 for a, b in zip(points, points[1:]))
    told["branches"] = rows(geometry.GetPointData(), ["GroupIds", *MEASURES])
    told["frames"] = rows(frames.GetPointData(), ["GroupIds", "Normal", "UpNormal"])
    for place, frame in enumerate(told["frames"]):
        frame["origin"] = frames.GetPoint(place)
    told["vectors"] = rows(
        vectors.GetPointData(),
        ["GroupIds", "BifurcationGroupIds", "Vector", "InPlaneAngle", "OutOfPlaneAngle", "Orientation"],
    )
    json.dump(rounded(told), open(out + ".json", "w"), separators=(",", ":"))
    blanked = {tract["GroupIds"] for tract in told["tracts"] if tract["Blanking"]}
    print(f"{lines.GetNumberOfCells()} lines, {len(told['branches'])} branches, {len(blanked)} bifurcations")


if __name__ == "__main__":
    main()
