// Trees of npm's `@dgreenheck/ez-tree`: node ez_tree.mjs MODULES FOLDER|--time [PRESET…]
//
// Writes FOLDER/PRESET.glb (oak-medium, bush-1, …; all presets where none is asked for), or, with --time, tells how long the making of a tree alone
// takes. MODULES is a node_modules folder with ez-tree and three in it.
import { writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const RUNS = 15;
const [modules, folder, ...wanted] = process.argv.slice(2);

// ez-tree has its pictures in it as data URIs, and three loads them through the page's image elements. These only remember where they are from:
// the bytes of the file go on as they are, so there is no need to decode them.
class Picture {
  addEventListener(kind, listener) {
    if (kind === "load") this.loaded = listener;
  }
  removeEventListener() {}
  set src(uri) {
    this.uri = uri;
    this.loaded?.call(this);
  }
}
globalThis.document = { createElementNS: () => new Picture() };
const { Tree, TreePreset } = await import(pathToFileURL(resolve(modules, "@dgreenheck/ez-tree/build/ez-tree.es.js")));

// "Trellis" is a frame with a bush on it.
const names = Object.keys(TreePreset).filter((name) => name !== "Trellis");
const presets = new Map(names.map((name) => [name.toLowerCase().replace(" ", "-"), name]));
for (const preset of wanted.length ? wanted : presets.keys()) {
  if (!presets.has(preset)) {
    console.error(`ez-tree has no ${preset}; it has ${[...presets.keys()].join(", ")}`);
    process.exit(1);
  }
  const tree = new Tree();
  tree.loadPreset(presets.get(preset));
  if (folder === "--time") time(preset, tree);
  else writeFileSync(join(folder, `${preset}.glb`), glb(preset, tree));
}

// The median of several runs, after one that the compiler has seen.
function time(preset, tree) {
  const seconds = Array.from({ length: RUNS }, () => {
    const start = performance.now();
    tree.generate();
    return (performance.now() - start) / 1000;
  }).sort((a, b) => a - b)[RUNS >> 1];
  const triangles = tree.triangleCount;
  console.log(`ez-tree ${preset}  ${triangles} triangles  ${seconds.toFixed(4)} s  ${(triangles / seconds / 1e6).toFixed(2)} million/s`);
}

// three's own exporter needs a canvas, which node has not, so the file is written here.
function glb(name, tree) {
  const parts = [];
  let length = 0;
  const json = {
    asset: { version: "2.0", generator: "ez-tree" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ name, children: [] }],
    meshes: [],
    materials: [],
    textures: [],
    images: [],
    samplers: [],
    accessors: [],
    bufferViews: [],
  };
  const put = (bytes, target) => {
    json.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length, target });
    parts.push(bytes, Buffer.alloc(-bytes.length & 3));
    length += (bytes.length + 3) & ~3;
    return json.bufferViews.length - 1;
  };
  const accessor = (array, type, size, more) => {
    const bufferView = put(Buffer.from(array.buffer, array.byteOffset, array.byteLength), type === "SCALAR" ? 34963 : 34962);
    const componentType = { Uint16Array: 5123, Float32Array: 5126 }[array.constructor.name];
    json.accessors.push({ bufferView, componentType, count: array.length / size, type, ...more });
    return json.accessors.length - 1;
  };
  const texture = (map) => {
    const [, mimeType, data] = map.image.uri.match(/^data:(.*?);base64,(.*)$/s);
    json.images.push({ mimeType, bufferView: put(Buffer.from(data, "base64")) });
    // Bark is repeated, leaves are not (three's 1000 and 1001).
    const wrap = map.wrapS === 1000 ? 10497 : 33071;
    json.samplers.push({ magFilter: 9729, minFilter: 9987, wrapS: wrap, wrapT: wrap });
    json.textures.push({ source: json.images.length - 1, sampler: json.samplers.length - 1 });
    return { index: json.textures.length - 1 };
  };
  for (const { geometry, material } of [tree.branchesMesh, tree.leavesMesh]) {
    if (!geometry.index.count) continue;
    const { position, normal, uv } = geometry.attributes;
    const places = [0, 1, 2].map((axis) => position.array.filter((_, place) => place % 3 === axis));
    const extreme = (of) => places.map((place) => place.reduce((a, b) => of(a, b)));
    // What three's repeat does to texture coordinates is done to them here; the first row of glTF's pictures is the upper one.
    const { repeat } = material.map;
    const st = uv.array.map((x, place) => (place % 2 ? 1 - x * repeat.y : x * repeat.x));
    const attributes = {
      POSITION: accessor(position.array, "VEC3", 3, { min: extreme(Math.min), max: extreme(Math.max) }),
      NORMAL: accessor(normal.array, "VEC3", 3),
      TEXCOORD_0: accessor(st, "VEC2", 2),
    };
    const primitive = { attributes, indices: accessor(geometry.index.array, "SCALAR", 1), material: json.materials.length };
    const leaf = material.alphaTest > 0;
    // Its surfaces are Phong's; what it sets of roughness is for a physical one, as here.
    json.materials.push({
      name: material.name,
      doubleSided: leaf,
      ...(leaf && { alphaMode: "MASK", alphaCutoff: material.alphaTest }),
      ...(material.normalMap && { normalTexture: texture(material.normalMap) }),
      ...(material.aoMap && { occlusionTexture: texture(material.aoMap) }),
      pbrMetallicRoughness: {
        baseColorFactor: [...material.color.toArray(), 1],
        baseColorTexture: texture(material.map),
        metallicFactor: 0,
        ...(material.roughnessMap && { metallicRoughnessTexture: texture(material.roughnessMap) }),
      },
    });
    json.nodes[0].children.push(json.nodes.length);
    json.nodes.push({ name: material.name, mesh: json.meshes.length });
    json.meshes.push({ name: material.name, primitives: [primitive] });
  }
  json.buffers = [{ byteLength: length }];
  const chunk = (kind, bytes, filler) => {
    const padding = Buffer.alloc(-bytes.length & 3, filler);
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length + padding.length, 0);
    head.write(kind, 4, "latin1");
    return Buffer.concat([head, bytes, padding]);
  };
  const chunks = [chunk("JSON", Buffer.from(JSON.stringify(json)), " "), chunk("BIN\0", Buffer.concat(parts), 0)];
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([head, ...chunks]);
}
