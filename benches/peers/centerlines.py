"""VMTK's centerlines of a model with a known truth: how far they are off, in local radii, and what they take.

    target/peers/vmtk/bin/python benches/peers/centerlines.py MODEL.ply TRUTH.seeds.json TRUTH.skeleton.json

The environment is what `scripts/peers.sh centerlines` makes. The same distances are taken of Ramus's lines by `cargo nextest run --lib lines_are_nearer --no-capture`.
"""

import json
import sys
import time

import numpy
from branches import RADIUS, found, surface
from vtk.util.numpy_support import vtk_to_numpy


def lines(data):
    points = vtk_to_numpy(data.GetPoints().GetData())
    radii = vtk_to_numpy(data.GetPointData().GetArray(RADIUS))
    for number in range(data.GetNumberOfCells()):
        cell = data.GetCell(number)
        ids = [cell.GetPointId(place) for place in range(cell.GetNumberOfPoints())]
        yield points[ids], radii[ids]


def resampled(points, radii, step):
    lengths = numpy.r_[0, numpy.cumsum(numpy.linalg.norm(numpy.diff(points, axis=0), axis=1))]
    places = numpy.arange(0, lengths[-1], step)
    at = [numpy.interp(places, lengths, points[:, axis]) for axis in range(3)]
    return numpy.stack(at, axis=1), numpy.interp(places, lengths, radii)


def nearest(points, truth):
    """Distance to the true axis and the true radius there."""
    nodes, radii = numpy.array(truth["nodes"]), numpy.array(truth["radius"])
    best, thick = numpy.full(len(points), numpy.inf), numpy.zeros(len(points))
    for node, parent in enumerate(truth["parent"]):
        if parent < 0:
            continue
        along = nodes[node] - nodes[parent]
        part = numpy.clip((points - nodes[parent]) @ along / (along @ along), 0, 1)
        distance = numpy.linalg.norm(points - nodes[parent] - part[:, None] * along, axis=1)
        radius = radii[parent] + part * (radii[node] - radii[parent])
        nearer = distance < best
        best[nearer], thick[nearer] = distance[nearer], radius[nearer]
    return best, thick


def off(data, truth):
    """How far points of lines are from the true axis, in true radii, and how far their radii are off, as a part; at equal steps."""
    distances, errors = [], []
    for points, radii in lines(data):
        points, radii = resampled(points, radii, 0.25 * min(truth["radius"]))
        distance, radius = nearest(points, truth)
        distances.append(distance / radius)
        errors.append(abs(radii / radius - 1))
    return numpy.concatenate(distances), numpy.concatenate(errors)


def main():
    model, seeds, truth = sys.argv[1], json.load(open(sys.argv[2])), json.load(open(sys.argv[3]))
    model = surface(model)
    started = time.process_time()
    data = found(model, seeds)
    seconds = time.process_time() - started
    distances, errors = off(data, truth)
    print(f"distance mean {distances.mean():.5f} median {numpy.median(distances):.5f}, radius {numpy.median(errors):.5f}; {seconds:.1f} CPU s for the lines")


if __name__ == "__main__":
    main()
