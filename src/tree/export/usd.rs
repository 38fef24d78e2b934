//! Universal Scene Description as text (`.usda`): a transform with a mesh for each material, which is a preview surface.
//!
//! Metres, Y up, normals and texture coordinates (`primvars:st`) at the vertices, `subdivisionScheme` none, since the tubes are already round. Bark has the colour
//! of bark: a text can hold no picture, and a second file would be lost too easily; who wants its texture takes the GLB. What is painted has its colours
//! at the vertices (`primvars:displayColor`, linear), read by its material. Specification: <https://openusd.org/release/api/usd_geom_page_front.html>
//! and <https://openusd.org/release/spec_usdpreviewsurface.html>.

use std::io::{self, Write};

use super::ExportParams;
use super::surface::{Group, Matter, Surface};
use crate::tree::organs::{Organs, bark_colour};
use crate::tree::{Tree, TreeError};

/// What the text of one vertex with its share of the faces takes at most, roughly.
const VERTEX_BYTES: u64 = 70 + 40 + 40 + 2 * 50;
/// Numbers on a line.
const LINE: usize = 12;

/// A USD file that is checked and not written yet.
#[derive(Debug)]
pub struct Usd<'a> {
    surface: Surface<'a>,
    segments: usize,
    organs: &'a Organs,
}

impl<'a> Usd<'a> {
    /// Checks a tree and what it carries.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large; sides outside 3 to 64.
    pub fn new(tree: &Tree, organs: &'a Organs, params: &ExportParams) -> Result<Self, TreeError> {
        Ok(Self {
            surface: Surface::new(tree, organs, params, "USD", VERTEX_BYTES)?,
            segments: tree.segment_count(),
            organs,
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        write!(
            out,
            "#usda 1.0\n(\n    defaultPrim = \"tree\"\n    doc = \"Ramus {}: a tree of {} segments\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\ndef Xform \"tree\" (\n    kind = \"component\"\n)\n{{\n",
            env!("CARGO_PKG_VERSION"),
            self.segments
        )?;
        for group in &self.surface.groups {
            self.mesh(group, out)?;
        }
        writeln!(out, "    def Scope \"materials\"\n    {{")?;
        for group in &self.surface.groups {
            self.material(group.matter, out)?;
        }
        writeln!(out, "    }}\n}}")
    }

    fn mesh(&self, group: &Group, out: &mut dyn Write) -> io::Result<()> {
        let (surface, name) = (&self.surface, name(group.matter));
        let [low, high] = group.bounds.map(|corner| triple(&corner));
        write!(
            out,
            "    def Mesh \"{name}\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{\n        uniform bool doubleSided = {}\n        float3[] extent = [{low}, {high}]\n        rel material:binding = </tree/materials/{name}>\n        uniform token subdivisionScheme = \"none\"\n",
            u8::from(group.matter != Matter::Bark)
        )?;
        let mut list = List::begin(out, "int[] faceVertexCounts")?;
        for _ in 0..group.indices / 3 {
            list.push(out, format_args!("3"))?;
        }
        list.end(out, "")?;
        let mut list = List::begin(out, "int[] faceVertexIndices")?;
        surface.each(group.matter, |part, before| {
            let mut indices = part.indices.iter();
            indices.try_for_each(|index| list.push(out, format_args!("{}", index + before)))
        })?;
        list.end(out, "")?;
        let mut list = List::begin(out, "point3f[] points")?;
        surface.each(group.matter, |part, _| {
            let mut points = part.positions.iter();
            points.try_for_each(|[x, y, z]| list.push(out, format_args!("({x}, {y}, {z})")))
        })?;
        list.end(out, "")?;
        // Five digits are finer than any shading shows.
        let mut list = List::begin(out, "normal3f[] normals")?;
        surface.each(group.matter, |part, _| {
            let mut normals = part.normals.iter();
            normals
                .try_for_each(|[x, y, z]| list.push(out, format_args!("({x:.5}, {y:.5}, {z:.5})")))
        })?;
        list.end(out, VERTEX)?;
        if group.matter == Matter::Bark {
            let mut list = List::begin(out, "texCoord2f[] primvars:st")?;
            surface.each(group.matter, |part, _| {
                let mut uvs = part.uvs.iter();
                uvs.try_for_each(|[u, v]| list.push(out, format_args!("({u}, {v})")))
            })?;
            list.end(out, VERTEX)?;
        } else {
            let mut list = List::begin(out, "color3f[] primvars:displayColor")?;
            surface.each(group.matter, |part, _| {
                let mut colours = part.colours.iter();
                colours.try_for_each(|[r, g, b]| {
                    list.push(out, format_args!("({r:.5}, {g:.5}, {b:.5})"))
                })
            })?;
            list.end(out, VERTEX)?;
        }
        writeln!(out, "    }}\n")
    }

    fn material(&self, matter: Matter, out: &mut dyn Write) -> io::Result<()> {
        let name = name(matter);
        let [metallic, roughness] = match matter {
            Matter::Bark => [0.0, 0.9],
            Matter::Painted(index) => {
                let material = self.organs.palette.material(index);
                [material.metallic, material.roughness]
            }
        };
        let colour = match matter {
            Matter::Bark => format!(" = {}", triple(&bark_colour())),
            Matter::Painted(_) => {
                format!(".connect = </tree/materials/{name}/colour.outputs:result>")
            }
        };
        write!(
            out,
            "        def Material \"{name}\"\n        {{\n            token outputs:surface.connect = </tree/materials/{name}/surface.outputs:surface>\n\n            def Shader \"surface\"\n            {{\n                uniform token info:id = \"UsdPreviewSurface\"\n                color3f inputs:diffuseColor{colour}\n                float inputs:metallic = {metallic}\n                float inputs:roughness = {roughness}\n                token outputs:surface\n            }}\n"
        )?;
        if matter != Matter::Bark {
            write!(
                out,
                "\n            def Shader \"colour\"\n            {{\n                uniform token info:id = \"UsdPrimvarReader_float3\"\n                string inputs:varname = \"displayColor\"\n                float3 outputs:result\n            }}\n"
            )?;
        }
        writeln!(out, "        }}")
    }
}

/// Behind a list whose numbers are each of one vertex.
const VERTEX: &str = " (\n            interpolation = \"vertex\"\n        )";

fn name(matter: Matter) -> String {
    match matter {
        Matter::Bark => "bark".to_owned(),
        Matter::Painted(index) => format!("material_{index}"),
    }
}

fn triple([x, y, z]: &[f32; 3]) -> String {
    format!("({x}, {y}, {z})")
}

/// A list being written, some numbers a line.
struct List {
    count: usize,
}

impl List {
    fn begin(out: &mut dyn Write, name: &str) -> io::Result<Self> {
        write!(out, "        {name} = [")?;
        Ok(Self { count: 0 })
    }

    fn push(&mut self, out: &mut dyn Write, number: std::fmt::Arguments<'_>) -> io::Result<()> {
        if self.count > 0 {
            let is_new = self.count.is_multiple_of(LINE);
            out.write_all(if is_new { b",\n            " } else { b", " })?;
        }
        self.count += 1;
        out.write_fmt(number)
    }

    fn end(self, out: &mut dyn Write, behind: &str) -> io::Result<()> {
        writeln!(out, "]{behind}")
    }
}
