//! Universal Scene Description as text (`.usda`): a transform named as the tree with a mesh for each thing that it is made of (`wood`, `leaves` …), whose
//! material is a preview surface. A grove has a transform for each tree in between; all share their materials.
//!
//! Metres, Y up, normals and texture coordinates (`primvars:st`) at the vertices, `subdivisionScheme` none, since the tubes are already round. Bark has the colour
//! of bark: a text can hold no picture, and a second file would be lost too easily; who wants its texture takes the GLB. What is painted has its colours
//! at the vertices (`primvars:displayColor`, linear), read by its material. Specification: <https://openusd.org/release/api/usd_geom_page_front.html>
//! and <https://openusd.org/release/spec_usdpreviewsurface.html>.

use std::io::{self, Write};

use super::instances::Run;
use super::names::{identifier, identifiers, name, unlike_identifier};
use super::surface::{Costs, Group, Matter, Standing, Surface, everywhere, fits, standing};
use super::{ExportParams, Place, Stand, TREE};
use crate::tree::bark::Bark;
use crate::tree::organs::{Numbers, Organs, bark_colour};
use crate::tree::{Tree, TreeError};

mod instancer;

use instancer::Site;

/// What the text of one vertex with its share of the faces takes at most, roughly, and that of an instance.
const COSTS: Costs = Costs {
    vertex: 70 + 40 + 40 + 2 * 50,
    instance: 4 + 45 + 45 + 40,
    once: true,
};
/// Numbers on a line.
const LINE: usize = 12;

/// A USD file that is checked and not written yet.
#[derive(Debug)]
pub struct Usd<'a> {
    /// Of the prim on top.
    name: String,
    is_grove: bool,
    trees: Vec<Standing<'a>>,
    materials: Vec<Material>,
}

/// A material that all trees share which look so.
#[derive(Clone, Debug, PartialEq)]
struct Material {
    /// Of its prim.
    name: String,
    /// As the tree has it.
    called: String,
    bark: Option<Bark>,
    metallic: f32,
    roughness: f32,
}

impl<'a> Usd<'a> {
    /// Checks a tree and what it carries.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large; sides outside 3 to 64.
    pub fn new(
        tree: &'a Tree,
        organs: &'a Organs,
        params: &ExportParams,
    ) -> Result<Self, TreeError> {
        Self::of(&Stand::of(TREE, tree, organs, params))
    }

    /// Whether there is room in such a file for all that stands in it, before any surface is made.
    ///
    /// # Errors
    /// [`TreeError::TooLarge`].
    pub fn check(stand: &Stand<'_>) -> Result<(), TreeError> {
        fits(stand, "USD", COSTS)
    }

    /// The same of all that stands in a file.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(stand: &Stand<'a>) -> Result<Self, TreeError> {
        let trees = standing(stand, "USD", COSTS)?;
        let mut materials: Vec<Material> = Vec::new();
        for Standing { surface, .. } in &trees {
            let of_runs = surface.runs.iter();
            let of_runs = of_runs.map(|run| Matter::Painted(run.paint.material));
            for matter in surface
                .groups
                .iter()
                .map(|group| group.matter)
                .chain(of_runs)
            {
                if !materials.iter().any(|known| known.is_of(surface, matter)) {
                    let mut made = Material::of(surface, matter);
                    let taken: Vec<String> = materials.iter().map(|one| one.name.clone()).collect();
                    made.name = unlike_identifier(&taken, &made.called);
                    materials.push(made);
                }
            }
        }
        Ok(Self {
            name: identifier(&stand.name),
            is_grove: stand.is_grove,
            trees,
            materials,
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let name = &self.name;
        let trees = || everywhere(&self.trees);
        let segments = trees().map(|(one, _)| one.surface.tree.segment_count());
        let segments: usize = segments.sum();
        let (what, kind) = match self.is_grove {
            true => (format!("{} trees", trees().count()), "group"),
            false => ("a tree".to_owned(), "component"),
        };
        write!(
            out,
            "#usda 1.0\n(\n    defaultPrim = \"{name}\"\n    doc = \"Ramus {}: {what} of {segments} segments\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\ndef Xform \"{name}\" (\n    kind = \"{kind}\"\n)\n{{\n",
            env!("CARGO_PKG_VERSION"),
        )?;
        for standing in &self.trees {
            self.tree(standing, out)?;
            self.further(standing, out)?;
        }
        writeln!(out, "    def Scope \"materials\"\n    {{")?;
        for material in &self.materials {
            self.material(material, out)?;
        }
        writeln!(out, "    }}\n}}")
    }

    /// A tree: in a grove below a transform of its own.
    fn tree(&self, standing: &Standing<'_>, out: &mut dyn Write) -> io::Result<()> {
        let surface = &standing.surface;
        let inside = if self.is_grove { "        " } else { "    " };
        if let Some(place) = standing.places.first().filter(|_| self.is_grove) {
            write!(
                out,
                "    def Xform \"{}\" (\n        kind = \"component\"\n    )\n    {{\n",
                identifier(&place.name)
            )?;
            stand_at(place, out)?;
            writeln!(out)?;
        }
        let mut taken = identifiers(surface);
        for (group, name) in surface.groups.iter().zip(&taken) {
            self.mesh(surface, group, name, inside, out)?;
        }
        let mut above = format!("/{}", self.name);
        if self.is_grove {
            above += &format!("/{}", identifier(standing.name()));
        }
        let same = |a: &Run, b: &Run| a.paint.material == b.paint.material;
        for runs in surface.runs.chunk_by(same) {
            let Some(first) = runs.first() else { continue };
            let matter = Matter::Painted(first.paint.material);
            let name = unlike_identifier(&taken, &name(surface, matter));
            taken.push(name.clone());
            let site = Site {
                name: &name,
                above: &above,
                material: &self.path(surface, matter),
                inside,
            };
            instancer::write(surface, runs, &site, out)?;
        }
        if self.is_grove {
            writeln!(out, "    }}\n")?;
        }
        Ok(())
    }

    /// Its further places: the same tree by a reference, so that programs keep one of it.
    fn further(&self, standing: &Standing<'_>, out: &mut dyn Write) -> io::Result<()> {
        let first = identifier(standing.name());
        for place in standing.places.iter().skip(1) {
            write!(
                out,
                "    def Xform \"{}\" (\n        instanceable = true\n        kind = \"component\"\n        prepend references = </{}/{first}>\n    )\n    {{\n",
                identifier(&place.name),
                self.name
            )?;
            stand_at(place, out)?;
            writeln!(out, "    }}\n")?;
        }
        Ok(())
    }

    /// The path of a material.
    fn path(&self, surface: &Surface<'_>, matter: Matter) -> String {
        let known = self.materials.iter().find(|one| one.is_of(surface, matter));
        let material = known.map_or("", |known| &known.name);
        format!("/{}/materials/{material}", self.name)
    }

    fn mesh(
        &self,
        surface: &Surface<'_>,
        group: &Group,
        name: &str,
        inside: &str,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let [low, high] = group.bounds.map(|corner| triple(&corner));
        let material = self.path(surface, group.matter);
        write!(
            out,
            "{inside}def Mesh \"{name}\" (\n{inside}    prepend apiSchemas = [\"MaterialBindingAPI\"]\n{inside})\n{inside}{{\n{inside}    uniform bool doubleSided = {}\n{inside}    float3[] extent = [{low}, {high}]\n{inside}    rel material:binding = <{material}>\n{inside}    uniform token subdivisionScheme = \"none\"\n",
            u8::from(group.matter != Matter::Bark),
        )?;
        let mut list = List::begin(out, inside, "int[] faceVertexCounts")?;
        for _ in 0..group.indices / 3 {
            list.push(out, format_args!("3"))?;
        }
        list.end(out, "")?;
        let mut list = List::begin(out, inside, "int[] faceVertexIndices")?;
        surface.each(group.matter, Numbers::INDICES, |part, before| {
            let mut indices = part.indices.iter();
            indices.try_for_each(|index| list.push(out, format_args!("{}", index + before)))
        })?;
        list.end(out, "")?;
        let mut list = List::begin(out, inside, "point3f[] points")?;
        surface.each(group.matter, Numbers::POSITIONS, |part, _| {
            let mut points = part.positions.iter();
            points.try_for_each(|[x, y, z]| list.push(out, format_args!("({x}, {y}, {z})")))
        })?;
        list.end(out, "")?;
        // Five digits are finer than any shading shows.
        let mut list = List::begin(out, inside, "normal3f[] normals")?;
        surface.each(group.matter, Numbers::NORMALS, |part, _| {
            let mut normals = part.normals.iter();
            normals
                .try_for_each(|[x, y, z]| list.push(out, format_args!("({x:.5}, {y:.5}, {z:.5})")))
        })?;
        list.end(out, VERTEX)?;
        if group.matter == Matter::Bark {
            let mut list = List::begin(out, inside, "texCoord2f[] primvars:st")?;
            surface.each(group.matter, Numbers::NONE, |part, _| {
                let mut uvs = part.uvs.iter();
                uvs.try_for_each(|[u, v]| list.push(out, format_args!("({u}, {v})")))
            })?;
            list.end(out, VERTEX)?;
        } else {
            let mut list = List::begin(out, inside, "color3f[] primvars:displayColor")?;
            surface.each(group.matter, Numbers::COLOURS, |part, _| {
                let mut colours = part.colours.iter();
                colours.try_for_each(|[r, g, b]| {
                    list.push(out, format_args!("({r:.5}, {g:.5}, {b:.5})"))
                })
            })?;
            list.end(out, VERTEX)?;
        }
        writeln!(out, "{inside}}}\n")
    }

    fn material(&self, material: &Material, out: &mut dyn Write) -> io::Result<()> {
        let Material {
            name,
            bark,
            metallic,
            roughness,
            ..
        } = material;
        let path = format!("/{}/materials/{name}", self.name);
        let colour = match bark {
            Some(_) => format!(" = {}", triple(&bark_colour())),
            None => format!(".connect = <{path}/colour.outputs:result>"),
        };
        write!(
            out,
            "        def Material \"{name}\"\n        {{\n            token outputs:surface.connect = <{path}/surface.outputs:surface>\n\n            def Shader \"surface\"\n            {{\n                uniform token info:id = \"UsdPreviewSurface\"\n                color3f inputs:diffuseColor{colour}\n                float inputs:metallic = {metallic}\n                float inputs:roughness = {roughness}\n                token outputs:surface\n            }}\n"
        )?;
        if bark.is_none() {
            write!(
                out,
                "\n            def Shader \"colour\"\n            {{\n                uniform token info:id = \"UsdPrimvarReader_float3\"\n                string inputs:varname = \"displayColor\"\n                float3 outputs:result\n            }}\n"
            )?;
        }
        writeln!(out, "        }}")
    }
}

impl Material {
    /// Without a name for its prim.
    fn of(surface: &Surface<'_>, matter: Matter) -> Self {
        let organs = surface.organs;
        match matter {
            Matter::Bark => Self {
                name: String::new(),
                called: "bark".to_owned(),
                bark: Some(organs.bark),
                metallic: 0.0,
                roughness: 0.9,
            },
            Matter::Painted(index) => {
                let material = organs.palette.material(index);
                Self {
                    name: String::new(),
                    called: organs.palette.name(index),
                    bark: None,
                    metallic: material.metallic,
                    roughness: material.roughness,
                }
            }
        }
    }

    /// Whether it is that of a group, whatever its prim is called.
    fn is_of(&self, surface: &Surface<'_>, matter: Matter) -> bool {
        let other = Self::of(surface, matter);
        let named = Self {
            name: self.name.clone(),
            ..other
        };
        *self == named
    }
}

/// Behind a list whose numbers are each of one vertex.
const VERTEX: &str = " (\n            interpolation = \"vertex\"\n        )";

/// Says where a tree stands: moved, turned about the vertical and sized, the last first.
fn stand_at(place: &Place, out: &mut dyn Write) -> io::Result<()> {
    let at = triple(&place.at.to_array());
    writeln!(out, "        double3 xformOp:translate = {at}")?;
    let mut order = String::from("\"xformOp:translate\"");
    if !place.is_plain() {
        let (yaw, size) = (place.yaw_deg, triple(&[place.size; 3]));
        write!(
            out,
            "        float xformOp:rotateY = {yaw}\n        float3 xformOp:scale = {size}\n"
        )?;
        order += ", \"xformOp:rotateY\", \"xformOp:scale\"";
    }
    writeln!(out, "        uniform token[] xformOpOrder = [{order}]")
}

fn triple([x, y, z]: &[f32; 3]) -> String {
    format!("({x}, {y}, {z})")
}

/// A list being written, some numbers a line.
struct List<'a> {
    count: usize,
    inside: &'a str,
}

impl<'a> List<'a> {
    fn begin(out: &mut dyn Write, inside: &'a str, name: &str) -> io::Result<Self> {
        write!(out, "{inside}    {name} = [")?;
        Ok(Self { count: 0, inside })
    }

    fn push(&mut self, out: &mut dyn Write, number: std::fmt::Arguments<'_>) -> io::Result<()> {
        if self.count > 0 {
            if self.count.is_multiple_of(LINE) {
                write!(out, ",\n{}        ", self.inside)?;
            } else {
                out.write_all(b", ")?;
            }
        }
        self.count += 1;
        out.write_fmt(number)
    }

    fn end(self, out: &mut dyn Write, behind: &str) -> io::Result<()> {
        writeln!(out, "]{behind}")
    }
}
