// The start-up probe: a grid of cells, each eye in colours of its own (see src/render/probe.rs).

struct Probe {
    // Cells along one side.
    side: u32,
    // Cells of one instance.
    batch: u32,
}

var<immediate> probe: Probe;

struct Point {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) color: vec4f,
}

fn cell_point(cell: u32, corner: u32, view: u32) -> Point {
    let x = cell % probe.side;
    let y = cell / probe.side;
    let far = vec2u(corner & 1u, corner >> 1u);
    // The grid is half as large again as the picture, so that some cells are clipped.
    let at = ((vec2f(vec2u(x, y) + far) / f32(probe.side)) * 2.0 - 1.0) * 1.5;
    var out: Point;
    out.position = vec4f(at, 0.5, 1.0);
    // View 0 red, view 1 green; the cell in blue.
    let c = f32(cell % 16u) / 15.0;
    out.color = select(vec4f(1.0, 0.0, c, 1.0), vec4f(0.0, 1.0, c, 1.0), view == 1u);
    return out;
}

// Indexed: four corners a cell.
@vertex
fn indexed_vertex(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    return cell_point(instance * probe.batch + vertex / 4u, vertex % 4u, view);
}

// Not indexed: six corners a cell.
@vertex
fn flat_vertex(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) instance: u32,
    @builtin(view_index) view: u32,
) -> Point {
    let corners = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u);
    return cell_point(instance * probe.batch + vertex / 6u, corners[vertex % 6u], view);
}

@fragment
fn probe_fragment(point: Point) -> @location(0) vec4f {
    return point.color;
}
