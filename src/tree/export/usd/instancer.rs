//! Instances in USD: a `PointInstancer` for each material, with a prototype for each look.
//!
//! Prototypes stand below the instancer, where they are not drawn by themselves. Specification: <https://openusd.org/release/api/class_usd_geom_point_instancer.html>.

use std::io::{self, Write};

use super::{List, VERTEX, triple};
use crate::tree::export::instances::Run;
use crate::tree::export::surface::Surface;

/// Where an instancer is written.
pub(super) struct Site<'a> {
    /// Its own name.
    pub(super) name: &'a str,
    /// The path of what it stands below.
    pub(super) above: &'a str,
    /// The path of its material.
    pub(super) material: &'a str,
    /// Before each line.
    pub(super) inside: &'a str,
}

/// Writes all that is placed of one material.
pub(super) fn write(
    surface: &Surface<'_>,
    runs: &[Run],
    site: &Site<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let Site {
        name,
        above,
        inside,
        ..
    } = site;
    writeln!(out, "{inside}def PointInstancer \"{name}\"\n{inside}{{")?;
    let mut list = List::begin(out, inside, "rel prototypes")?;
    for look in 1..=runs.len() {
        list.push(out, format_args!("<{above}/{name}/looks/look_{look}>"))?;
    }
    list.end(out, "")?;
    let placed = || {
        let of = |at: &u32| surface.organs.placed.get(*at as usize);
        let all = runs.iter().flat_map(|run| &run.placed);
        all.filter_map(of)
    };
    let mut list = List::begin(out, inside, "int[] protoIndices")?;
    for (look, run) in runs.iter().enumerate() {
        for _ in &run.placed {
            list.push(out, format_args!("{look}"))?;
        }
    }
    list.end(out, "")?;
    let mut list = List::begin(out, inside, "point3f[] positions")?;
    for one in placed() {
        let [x, y, z] = one.position.to_array();
        list.push(out, format_args!("({x}, {y}, {z})"))?;
    }
    list.end(out, "")?;
    // The real part first; half precision is what it is read as.
    let mut list = List::begin(out, inside, "quath[] orientations")?;
    for one in placed() {
        let [x, y, z, w] = one.orientation.normalize().to_array();
        list.push(out, format_args!("({w:.4}, {x:.4}, {y:.4}, {z:.4})"))?;
    }
    list.end(out, "")?;
    let mut list = List::begin(out, inside, "float3[] scales")?;
    for one in placed() {
        let scale = one.scale;
        list.push(out, format_args!("({scale}, {scale}, {scale})"))?;
    }
    list.end(out, "")?;
    writeln!(out, "\n{inside}    def Scope \"looks\"\n{inside}    {{")?;
    for (look, run) in (1..).zip(runs) {
        prototype(surface, run, look, site, out)?;
    }
    writeln!(out, "{inside}    }}\n{inside}}}\n")
}

/// The mesh of a look.
fn prototype(
    surface: &Surface<'_>,
    run: &Run,
    look: usize,
    site: &Site<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let Some(leaf) = surface.organs.surfaces.get(usize::from(run.surface)) else {
        return Ok(());
    };
    let inside = &format!("{}        ", site.inside);
    write!(
        out,
        "{inside}def Mesh \"look_{look}\" (\n{inside}    prepend apiSchemas = [\"MaterialBindingAPI\"]\n{inside})\n{inside}{{\n{inside}    uniform bool doubleSided = 1\n{inside}    rel material:binding = <{}>\n{inside}    uniform token subdivisionScheme = \"none\"\n",
        site.material,
    )?;
    let mut list = List::begin(out, inside, "int[] faceVertexCounts")?;
    for _ in 0..leaf.indices.len() / 3 {
        list.push(out, format_args!("3"))?;
    }
    list.end(out, "")?;
    let mut list = List::begin(out, inside, "int[] faceVertexIndices")?;
    for index in &leaf.indices {
        list.push(out, format_args!("{index}"))?;
    }
    list.end(out, "")?;
    let rows = [
        ("point3f[] points", &leaf.positions, ""),
        ("normal3f[] normals", &leaf.normals, VERTEX),
    ];
    for (name, rows, behind) in rows {
        let mut list = List::begin(out, inside, name)?;
        for row in rows {
            list.push(out, format_args!("{}", triple(&row.to_array())))?;
        }
        list.end(out, behind)?;
    }
    let mut list = List::begin(out, inside, "color3f[] primvars:displayColor")?;
    for [r, g, b] in run.colours(surface.organs) {
        list.push(out, format_args!("({r:.5}, {g:.5}, {b:.5})"))?;
    }
    list.end(out, VERTEX)?;
    writeln!(out, "{inside}}}")
}
