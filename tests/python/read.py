"""Reads files with trimesh and says, a JSON line each, what it finds in them: read.py FILE..."""

import json
import sys

import numpy
import trimesh


def alpha_of(mesh):
    """How a mesh is seen through: glTF's alphaMode, OPAQUE unless said."""
    return getattr(getattr(mesh.visual, "material", None), "alphaMode", None) or "OPAQUE"


def has_picture(mesh):
    material = getattr(mesh.visual, "material", None)
    return getattr(material, "baseColorTexture", None) is not None or getattr(material, "image", None) is not None


for path in sys.argv[1:]:
    scene = trimesh.load_scene(path, process=False)
    # Each mesh where it stands.
    meshes = scene.dump()
    print(
        json.dumps(
            {
                "triangles": sum(len(mesh.faces) for mesh in meshes),
                "min": scene.bounds[0].tolist(),
                "max": scene.bounds[1].tolist(),
                "names": sorted(scene.geometry),
                "pictured": sum(has_picture(mesh) for mesh in meshes),
                "alpha": sorted({alpha_of(mesh) for mesh in meshes}),
                "area": float(sum(mesh.area for mesh in meshes)),
                "finite": bool(all(numpy.isfinite(mesh.vertices).all() for mesh in meshes)),
            }
        )
    )
