"""Pictures of trees in GLB files, side by side, by Blender:

    blender --background --factory-startup --python-exit-code 1 --python pictures.py -- OUT.png SIZE LABEL=FILE.glb ...

Tells on stderr (Blender talks on stdout) what was found in each file, stands each tree on the same ground in the same sun and sky, and joins the
pictures, SIZE pixels square, in one row. Materials stay as Blender imports them, for the files are what is tried. Needs numpy, as Blender's own
importer does (Debian's python3-numpy).
"""

import json
import math
import struct
import sys
import tempfile
import time
from pathlib import Path

import _cycles
import bpy
import numpy
from mathutils import Quaternion, Vector

# Debian's importer (Blender 3.4) uses a name that Debian's numpy no longer has.
if "bool" not in vars(numpy):
    numpy.bool = bool

INSTANCES = "EXT_mesh_gpu_instancing"
SAMPLES = 64
# Degrees: the sun over the horizon; the camera looks down so far that the shadow is seen.
SUN, DOWN = 42, 4
# Half of what the camera sees, at a distance of one.
HALF = 0.36
# Of the picture's side: room under the tree for its shadow and the label, over it, and beside it.
UNDER, OVER, BESIDE = 0.15, 0.04, 0.03


def say(line):
    print(line, file=sys.stderr, flush=True)


def main(out, size, files):
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for number, (label, file) in enumerate(files):
            bpy.ops.wm.read_factory_settings(use_empty=True)
            started = time.perf_counter()
            objects = read(file, Path(folder))
            stage(label, tell(label, file, objects, time.perf_counter() - started))
            pictures.append(render(size, Path(folder) / f"{number}.png"))
    save(out, numpy.concatenate(pictures, axis=1))
    say(f"{out}: {len(pictures)} pictures")


def read(file, folder):
    """Imports a file. Blender before 3.6 has no instances and refuses a file that requires them: those of such a file are put in here."""
    data = file.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    told = json.loads(data[20 : 20 + length])
    instances = {}
    if INSTANCES in told.get("extensionsUsed", []) and bpy.app.version < (3, 6, 0):
        for number, node in enumerate(told["nodes"]):
            if found := node.get("extensions", {}).pop(INSTANCES, None):
                node["name"] = f"instances {number}"
                arrays = {name: array(told, data[28 + length :], place) for name, place in found["attributes"].items()}
                instances[node["name"]] = arrays
        for key in ("extensionsUsed", "extensionsRequired"):
            told[key] = [name for name in told.get(key, []) if name != INSTANCES]
            if not told[key]:
                del told[key]
        text = json.dumps(told).encode()
        text += b" " * (-len(text) % 4)
        rest = data[20 + length :]
        head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) + struct.pack("<I4s", len(text), b"JSON")
        file = folder / "instances.glb"
        file.write_bytes(head + text + rest)
    bpy.ops.import_scene.gltf(filepath=str(file))
    for name, arrays in instances.items():
        put_instances(bpy.data.objects[name], arrays)
    return [one for one in bpy.context.scene.objects if one.type == "MESH" and not one.hide_render]


def array(told, binary, place):
    accessor = told["accessors"][place]
    view = told["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    if accessor["componentType"] != 5126 or view.get("byteStride", 4 * width) != 4 * width:
        raise SystemExit("instances are read as packed floats only")
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return numpy.frombuffer(binary, "<f4", accessor["count"] * width, start).reshape(-1, width)


def put_instances(first, arrays):
    count = len(next(iter(arrays.values())))
    moves = arrays.get("TRANSLATION", numpy.zeros((count, 3)))
    turns = arrays.get("ROTATION", numpy.tile((0, 0, 0, 1), (count, 1)))
    scales = arrays.get("SCALE", numpy.ones((count, 3)))
    first.hide_render = True
    for (x, y, z), (i, j, k, w), (a, b, c) in zip(moves.tolist(), turns.tolist(), scales.tolist()):
        one = bpy.data.objects.new("instance", first.data)
        # glTF's second axis is up, Blender's third.
        one.location, one.rotation_mode, one.rotation_quaternion, one.scale = (x, -z, y), "QUATERNION", Quaternion((w, i, -k, j)), (a, c, b)
        one.parent = first
        bpy.context.scene.collection.objects.link(one)
    bpy.context.view_layer.update()


def tell(label, file, objects, seconds):
    """Prints the facts; the places of what is to be seen."""
    places, triangles, drawn, bare = [], 0, {}, 0
    meshes = {}
    for one in objects:
        mesh = one.data
        if mesh.name not in meshes:
            mesh.calc_loop_triangles()
            flat = numpy.empty(3 * len(mesh.vertices), "f4")
            mesh.vertices.foreach_get("co", flat)
            meshes[mesh.name] = len(mesh.loop_triangles), flat.reshape(-1, 3)
        count, own = meshes[mesh.name]
        triangles += count
        world = numpy.array(one.matrix_world)
        places.append(own @ world[:3, :3].T + world[:3, 3])
        drawn.update((material.name, material) for material in mesh.materials if material)
        bare += not any(mesh.materials)
    places = numpy.concatenate(places)
    low, high = places.min(0), places.max(0)
    sides = high - low
    # The axis on whose zero the tree stands; in the words of the file, whose second axis is Blender's third.
    axes = [name for name, axis in (("+x", 0), ("-z", 1), ("+y", 2)) if abs(low[axis]) < 0.03 * sides[axis]]
    axes += [name for name, axis in (("-x", 0), ("+z", 1), ("-y", 2)) if abs(high[axis]) < 0.03 * sides[axis]]
    say(f"{label} ({file.name}, {file.stat().st_size / 1e6:.1f} MB, imported in {seconds:.1f} s)")
    say(f"  objects {len(objects)}, meshes {len(meshes)}, without material {bare}, triangles {triangles}")
    say(f"  box in metres, as the file has it: x {sides[0]:.2f}, y {sides[2]:.2f}, z {sides[1]:.2f}; lowest point y = {low[2]:.3f}")
    say(f"  stands on the zero of: {', '.join(axes) or 'no axis'} (glTF: +y)")
    for name, material in sorted(drawn.items()):
        images = [node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE" and node.image]
        alpha = {"OPAQUE": "opaque", "CLIP": f"mask at {material.alpha_threshold:.2f}", "BLEND": "blend"}.get(material.blend_method, "mask")
        sides = "one side" if material.use_backface_culling else "both sides"
        say(f"  material {name}: {alpha}, {sides}, {', '.join(f'{i.name} {i.size[0]}x{i.size[1]}' for i in images) or 'no picture'}")
    return places


def stage(label, places):
    scene = bpy.context.scene
    low, high = places.min(0), places.max(0)
    # The ground goes on as far as the sky's lower edge.
    bpy.ops.mesh.primitive_plane_add(size=1000 * max(high - low), location=(0, 0, low[2]))
    bpy.context.object.data.materials.append(plain("ground", (0.34, 0.33, 0.26)))
    sky(scene)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.data.color = 4.5, math.radians(2.5), (1.0, 0.95, 0.86)
    # From behind the camera's left shoulder: the shadow falls to the right and away.
    sun.rotation_euler = (math.radians(90 - SUN), 0, math.radians(-48))
    scene.collection.objects.link(sun)
    camera(scene, label, places)


def plain(name, colour, glow=False):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader = nodes.new("ShaderNodeEmission" if glow else "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*colour, 1)
    links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def sky(scene):
    """White at the horizon, light blue above."""
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    nodes.clear()
    place, split, ramp = (nodes.new(kind) for kind in ("ShaderNodeTexCoord", "ShaderNodeSeparateXYZ", "ShaderNodeValToRGB"))
    lit, out = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    links.new(place.outputs["Generated"], split.inputs[0])
    links.new(split.outputs["Z"], ramp.inputs[0])
    links.new(ramp.outputs[0], lit.inputs["Color"])
    links.new(lit.outputs[0], out.inputs["Surface"])
    ramp.color_ramp.elements[0].color = (0.92, 0.94, 0.96, 1)
    ramp.color_ramp.elements[1].color = (0.40, 0.60, 0.90, 1)


def camera(scene, label, places):
    """From as near as all places can be seen, with a label under them."""
    data = bpy.data.cameras.new("camera")
    data.sensor_width, data.lens = 2 * HALF * 50, 50
    one = bpy.data.objects.new("camera", data)
    one.rotation_euler = (math.radians(90 - DOWN), 0, 0)
    turn = one.rotation_euler.to_matrix()
    x, y, z = (places @ numpy.array(turn)).T
    # Each edge of the picture is a plane through the camera, and bounds it by the place that is farthest over it.
    left, right, under, over = (HALF * (1 - 2 * room) for room in (BESIDE, BESIDE, UNDER, OVER))
    x0, x1, y0, y1 = (left * z - x).max(), (right * z + x).max(), (under * z - y).max(), (over * z + y).max()
    back = max((x0 + x1) / (left + right), (y0 + y1) / (under + over))
    one.location = turn @ Vector(((x1 - x0 + (left - right) * back) / 2, (y1 - y0 + (under - over) * back) / 2, back))
    data.clip_start, data.clip_end = back / 1000, 1000 * back
    scene.collection.objects.link(one)
    scene.camera = one
    # So near that nothing is before it, and without a part in the light.
    away = back / 50
    letters = bpy.data.curves.new("label", "FONT")
    letters.body, letters.align_x, letters.size = label, "CENTER", 0.1 * HALF * away
    letters.materials.append(plain("label", (0.02, 0.02, 0.02), glow=True))
    text = bpy.data.objects.new("label", letters)
    text.parent, text.location = one, (0, -0.95 * HALF * away, -away)
    text.visible_shadow = text.visible_diffuse = text.visible_glossy = text.visible_transmission = False
    scene.collection.objects.link(text)


def render(size, file):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_adaptive_sampling = "CPU", SAMPLES, True
    cycles.adaptive_threshold, cycles.adaptive_min_samples = 0.02, 32
    # A crown is many masked leaves deep: what gives up after eight of them is black inside.
    cycles.transparent_max_bounces = 128
    cycles.max_bounces, cycles.sample_clamp_indirect, cycles.seed = 6, 4, 1
    cycles.use_denoising = _cycles.with_openimagedenoise
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.filepath = str(file)
    started = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    say(f"  drawn in {time.perf_counter() - started:.0f} s")
    image = bpy.data.images.load(str(file))
    pixels = numpy.empty(4 * size * size, "f4")
    image.pixels.foreach_get(pixels)
    return pixels.reshape(size, size, 4)


def save(out, pixels):
    height, width, _ = pixels.shape
    image = bpy.data.images.new("sheet", width, height)
    image.pixels.foreach_set(numpy.ascontiguousarray(pixels).ravel())
    image.filepath_raw, image.file_format = str(out.resolve()), "PNG"
    image.save()


arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
if len(arguments) < 3:
    raise SystemExit(__doc__)
pairs = [text.partition("=") for text in arguments[2:]]
main(Path(arguments[0]), int(arguments[1]), [(label, Path(file)) for label, _, file in pairs])
