"""Reads models with one library from PyPI: models.py LIBRARY; beside it, what models.rs asks for.

On standard input a line "parse FILE" or "draw FILE"; on standard output the answer "SECONDS TRIANGLES VERTICES", or "- " and why not.
What was read is let go of behind the time, and the collector of garbage rests within it.
"""

import gc
import logging
import sys
import time


def trimesh():
    import trimesh

    def parse(path):
        return trimesh.load(path, process=False)

    def draw(path):
        # Processing drops what is not finite and merges vertices.
        mesh = trimesh.load(path, process=True, merge_tex=True, merge_norm=True)
        if isinstance(mesh, trimesh.Scene):
            mesh = mesh.to_mesh()
        return mesh, mesh.vertex_normals

    def count(made):
        made = made[0] if isinstance(made, tuple) else made
        parts = made.geometry.values() if isinstance(made, trimesh.Scene) else [made]
        return sum(len(p.faces) for p in parts), sum(len(p.vertices) for p in parts)

    return parse, draw, count


def pyvista():
    import pyvista

    def parse(path):
        return pyvista.read(path)

    def draw(path):
        mesh = pyvista.read(path)
        if isinstance(mesh, pyvista.MultiBlock):
            mesh = mesh.combine().extract_surface()
        # Corners stay shared at sharp edges, as the others have them.
        return mesh.clean().compute_normals(cell_normals=False, split_vertices=False)

    def count(made):
        parts = [made]
        while any(isinstance(part, pyvista.MultiBlock) for part in parts):
            parts = [block for part in parts
                     for block in (part if isinstance(part, pyvista.MultiBlock) else [part])]
        return sum(p.n_cells for p in parts), sum(p.n_points for p in parts)

    return parse, draw, count


def meshio():
    import meshio

    def count(made):
        triangles = sum(len(cells.data) for cells in made.cells if cells.type == "triangle")
        return triangles, len(made.points)

    return meshio.read, None, count


def main():
    logging.disable(logging.CRITICAL)
    answers, sys.stdout = sys.stdout, sys.stderr
    library = {"trimesh": trimesh, "pyvista": pyvista, "meshio": meshio}[sys.argv[1]]
    parse, draw, count = library()
    for line in sys.stdin:
        what, path = line.rstrip("\n").split(" ", 1)
        work = parse if what == "parse" else draw
        if work is None:
            print("- it makes no normals", file=answers, flush=True)
            continue
        try:
            gc.collect()
            gc.disable()
            start = time.perf_counter()
            made = work(path)
            seconds = time.perf_counter() - start
            gc.enable()
            print(seconds, *count(made), file=answers, flush=True)
            del made
        except BaseException as fault:  # meshio ends the program on what it cannot read
            gc.enable()
            text = " ".join(f"{type(fault).__name__}: {fault}".split())
            print("-", text, file=answers, flush=True)


main()
