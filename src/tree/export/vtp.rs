//! VTP: centerlines as VMTK and 3D Slicer read them.
//!
//! VTK's XML format for lines (<https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html>). As VMTK has it, each tip has a line of its
//! own from the root on, stretches that lines share are there as often, and radii are the point array `MaximumInscribedSphereRadius`.
//! Numbers are text, with as many digits as bring back the same value; positions get back the origin that they were counted from.

use std::io::{self, Write};

use glam::DVec3;

use crate::tree::{NO_PARENT, Tree, TreeError};

/// The name that VMTK gives radii.
const RADIUS: &str = "MaximumInscribedSphereRadius";

/// Points of all lines together at most: stretches near the root are there once for each tip.
const POINTS_MOST: usize = 100_000_000;

/// A VTP file that is checked and not written yet.
#[derive(Clone, Debug)]
pub struct Vtp<'a> {
    tree: &'a Tree,
    origin: DVec3,
    lines: Vec<Vec<u32>>,
}

impl<'a> Vtp<'a> {
    /// Checks a tree; `origin` is where its positions are counted from.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has no segment, or has more points than are written.
    pub fn new(tree: &'a Tree, origin: DVec3) -> Result<Self, TreeError> {
        tree.validate()?;
        if tree.segment_count() == 0 {
            return Err(TreeError::Empty("VTP"));
        }
        let mut lines = Vec::new();
        let mut points = 0_usize;
        for tip in tree.tips() {
            let mut line = vec![tip];
            let mut at = tree.parent[tip as usize];
            while at != NO_PARENT {
                line.push(at);
                at = tree.parent[at as usize];
            }
            points += line.len();
            if points > POINTS_MOST {
                return Err(TreeError::TooManyNodes(points));
            }
            line.reverse();
            if line.len() > 1 {
                lines.push(line);
            }
        }
        Ok(Self {
            tree,
            origin,
            lines,
        })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let points: usize = self.lines.iter().map(Vec::len).sum();
        let nodes = || self.lines.iter().flatten().map(|node| *node as usize);
        writeln!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
             <Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
            self.lines.len()
        )?;
        writeln!(
            out,
            "<PointData Scalars=\"{RADIUS}\">\n<DataArray type=\"Float64\" Name=\"{RADIUS}\" format=\"ascii\">"
        )?;
        for node in nodes() {
            writeln!(out, "{:?}", f64::from(self.tree.radius[node]))?;
        }
        writeln!(
            out,
            "</DataArray>\n</PointData>\n<CellData/>\n<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
        )?;
        for node in nodes() {
            let point = self.tree.position[node].as_dvec3() + self.origin;
            writeln!(out, "{:?} {:?} {:?}", point.x, point.y, point.z)?;
        }
        writeln!(
            out,
            "</DataArray>\n</Points>\n<Lines>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">"
        )?;
        let mut first = 0;
        for line in &self.lines {
            for number in first..first + line.len() {
                write!(out, "{number} ")?;
            }
            writeln!(out)?;
            first += line.len();
        }
        writeln!(
            out,
            "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">"
        )?;
        let mut end = 0;
        for line in &self.lines {
            end += line.len();
            writeln!(out, "{end}")?;
        }
        writeln!(
            out,
            "</DataArray>\n</Lines>\n</Piece>\n</PolyData>\n</VTKFile>"
        )
    }
}
