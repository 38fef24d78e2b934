"""Centerlines by VMTK and by `ramus analyze`, in one run, on the same models between the same ends: one table.

    beside_vmtk.py RAMUS FOLDER MODEL.ply...      # scripts/peers.sh centerlines

MODEL.seeds.json has the ends, else they are those that Ramus proposes; MODEL.skeleton.json, where it is there, the truth. FOLDER takes what is made.
"Apart" is how far Ramus's lines are from VMTK's at most, in radii of the balls there, on the ways to targets that both reach. Every run is a process of its
own, one at a time. Ramus's processor time is that of the whole program, which reads, checks, finds and measures; VMTK's is of reading,
finding lines, cutting them into branches, and their measures, reference systems and vectors, without Python's start and imports. Memory is
the most that the process had at once (resident set). What is short is run three times, and the median stands.
"""

import json
import math
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Processor seconds that VMTK has for a model: its search may go round for ever.
LIMIT = 300
# What has taken less is done thrice.
SHORT = 25


def ends(model):
    """The seeds of a model of several sizes are the same."""
    stem = model.with_suffix("")
    for name in (stem.name, stem.name.rsplit("_", 1)[0]):
        seeds, truth = (stem.with_name(f"{name}.{what}.json") for what in ("seeds", "skeleton"))
        if seeds.exists():
            return json.loads(seeds.read_text()), json.loads(truth.read_text()) if truth.exists() else None
    return None, None


def proposed(ramus, model):
    printed, _, _, why = run([ramus, "analyze", str(model), "--auto", "--json"])
    if why:
        raise SystemExit(f"ramus cannot analyze {model}: it {why}")
    told = json.loads(printed)["endpoints"]
    return {"source": told["source"], "targets": told["targets"]}


def run(arguments, limit=None):
    """What a process printed, its processor seconds, the most memory it had in MB, and why it did not end well, if so."""
    bound = lambda: limit and resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    with tempfile.TemporaryFile() as complaints:
        with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=complaints, preexec_fn=bound) as process:
            printed = process.stdout.read()
            _, status, used = os.wait4(process.pid, 0)
            code = process.returncode = os.waitstatus_to_exitcode(status)
        complaints.seek(0)
        last = (complaints.read().decode(errors="replace").strip().splitlines() or [""])[-1]
    why = f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with {code}: {last}"
    return printed, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, why if code else None


def by_ramus(ramus, model, seeds, folder):
    table = folder / "ends.csv"
    places = [("source", seeds["source"])] + [("target", target) for target in seeds["targets"]]
    rows = [f"end {number},{kind},{x!r},{y!r},{z!r}" for number, (kind, (x, y, z)) in enumerate(places)]
    table.write_text("\n".join(["name,kind,x,y,z", *rows, ""]))
    once = [ramus, "analyze", str(model), "--targets", str(table), "--json"]
    runs = [run(once) for _ in range(3)]
    if runs[0][3]:
        raise SystemExit(f"ramus cannot analyze {model}: it {runs[0][3]}")
    told = json.loads(runs[0][0])
    lines = folder / "ramus.vtp"
    run([*once, "--export", str(lines)])
    reached = len(seeds["targets"]) - len(told["endpoints"]["unreached"])
    return told["model"]["triangles"], reached, *(statistics.median(one[place] for one in runs) for place in (1, 2)), lines


def by_vmtk(model, seeds, folder):
    (folder / "seeds.json").write_text(json.dumps(seeds))
    lines = folder / "vmtk.vtp"
    runs = []
    while len(runs) < 3 and (not runs or runs[0][1] < SHORT):
        printed, seconds, memory, why = run([sys.executable, __file__, "--vmtk", str(model), str(folder / "seeds.json"), str(lines)], LIMIT)
        if why and seconds > LIMIT - 5:
            return f"not in {LIMIT} s", None, memory, None
        if why:
            print(f"VMTK fails on {model.stem}: after {seconds:.0f} s it {why}")
            return "failed", None, memory, None
        # VMTK prints, too.
        told = json.loads(printed.splitlines()[-1])
        runs.append((told["reached"], told["seconds"], memory))
    return runs[0][0], *(statistics.median(one[place] for one in runs) for place in (1, 2)), lines


def vmtk_alone(model, seeds, out):
    """A process of `by_vmtk`."""
    from branches import branches, found, surface, written

    seeds = json.load(open(seeds))
    started = time.process_time()
    lines = found(surface(model), seeds)
    if lines.GetNumberOfCells():
        branches(lines)
    seconds = time.process_time() - started
    written(lines, out)
    # A target that is not reached has a stub, or no line: what is reached lies half as far apart as the ends, at least.
    apart = min(math.dist(seeds["source"], target) for target in seeds["targets"]) / 2
    cells = [lines.GetCell(cell).GetPoints() for cell in range(lines.GetNumberOfCells())]
    reached = sum(math.dist(points.GetPoint(0), points.GetPoint(points.GetNumberOfPoints() - 1)) > apart for points in cells)
    print("\n" + json.dumps({"reached": reached, "seconds": seconds}))


def off_alone(lines, truth):
    """A process of `off`."""
    from branches import surface
    from centerlines import off

    print(off(surface(lines), json.load(open(truth)))[0].mean())


def off(lines, truth, folder):
    """Mean distance to the true axis in radii. This process stays small: what it has counts as its children's until they begin."""
    (folder / "truth.json").write_text(json.dumps(truth))
    printed, _, _, why = run([sys.executable, __file__, "--off", str(lines), str(folder / "truth.json")])
    return "–" if why else f"{float(printed):.4f}"


def apart_alone(ours, theirs):
    """A process of `apart`."""
    import numpy
    from branches import surface
    from centerlines import lines, nearest

    ours, theirs = (list(lines(surface(path))) for path in (ours, theirs))
    most = 0
    for points, radii in ours:
        # The way to the same target; there is none where VMTK has but a stub.
        same = [way for way, thick in theirs if len(way) > 1 and math.dist(way[-1], points[-1]) < 2 * (thick[-1] + radii[-1])]
        for way in same[:1]:
            chain = {"nodes": way, "parent": range(-1, len(way) - 1), "radius": numpy.ones(len(way))}
            most = max(most, (nearest(points, chain)[0] / radii).max())
    print(most)


def apart(ours, theirs):
    printed, _, _, why = run([sys.executable, __file__, "--apart", str(ours), str(theirs)])
    return "–" if why else f"{float(printed):.2f}"


def row(ramus, model, folder):
    seeds, truth = ends(model)
    seeds = seeds or proposed(ramus, model)
    triangles, reached, seconds, memory, lines = by_ramus(ramus, model, seeds, folder)
    theirs, their_seconds, their_memory, their_lines = by_vmtk(model, seeds, folder)
    # What reaches nothing is soon done.
    nothing = theirs in (0, "failed")
    times = lambda ours, theirs: "–" if nothing else f"×{theirs / ours:.1f}" if theirs else f">×{LIMIT / ours:.0f}"
    shown = [f"{model.stem}", f"{triangles}", f"{len(seeds['targets'])}", f"{reached}", f"{theirs}"]
    shown += [f"{seconds:.2f}", f"{their_seconds:.1f}" if their_seconds else "–", times(seconds, their_seconds)]
    shown += [f"{memory:.0f}", f"{their_memory:.0f}", f"×{their_memory / memory:.1f}"]
    shown += [off(lines, truth, folder) if truth and lines else "–" for lines in (lines, their_lines)]
    return shown + [apart(lines, their_lines) if lines and their_lines and not nothing else "–"]


HEADS = ["model", "triangles", "ends", "reached", "VMTK", "CPU s", "VMTK", "ratio", "MB", "VMTK", "ratio", "off", "VMTK", "apart"]
WIDTHS = [27, 10, 5, 8, 13, 7, 7, 7, 6, 6, 6, 7, 7, 6]


def main():
    ramus, folder, models = sys.argv[1], Path(sys.argv[2]), [Path(model) for model in sys.argv[3:]]
    _, _, bare, _ = run([sys.executable, "-c", "import sys; sys.path.insert(0, sys.argv[1]); import branches", str(Path(__file__).parent)])
    load = os.getloadavg()[0]
    print(f"\ncenterlines by ramus and by VMTK; {os.cpu_count()} cores, load before the run {load:.1f}; of VMTK's memory {bare:.0f} MB are Python and libraries")
    line = lambda cells: " ".join(f"{cell:<{width}}" if place == 0 else f"{cell:>{width}}" for place, (cell, width) in enumerate(zip(cells, WIDTHS)))
    print(line(HEADS), flush=True)
    for model in models:
        print(line(row(ramus, model, folder)), flush=True)


if __name__ == "__main__":
    alone = {"--vmtk": vmtk_alone, "--off": off_alone, "--apart": apart_alone}
    if sys.argv[1] in alone:
        alone[sys.argv[1]](*sys.argv[2:])
    else:
        main()
