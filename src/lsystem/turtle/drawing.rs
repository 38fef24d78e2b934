//! The canvas that keeps everything: the skeleton and what it carries.

use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::super::error::{DeriveError, DeriveProblem};
use super::super::grammar::Grammar;
use super::super::string::ModuleString;
use super::action::draws_organs;
use super::canvas::{Canvas, Drawn, Outline, narrow, narrowed};
use super::pen::{Cylinder, Pen};
use super::{TreeCanvas, TurtleParams, draw_on, interpret};
use crate::tree::Drawing;
use crate::tree::organs::{MOST_CORNERS, Organs, Paint, Placed, Polygon, Smooth, Sphere};

/// Bytes of a node in all arrays of a tree.
const NODE_BYTES: u64 = 28;

/// Draws a string with everything that it draws; the skeleton is that of [`super::interpret`].
///
/// # Errors
/// As [`super::interpret`]; polygons with too many corners.
pub fn draw(
    grammar: &Grammar,
    string: &ModuleString,
    params: &TurtleParams,
    cancel: &AtomicBool,
) -> Result<Drawing, DeriveError> {
    if !draws_organs(grammar, params) {
        // A tree alone is drawn in parts beside each other.
        let tree = interpret(grammar, string, params, cancel)?;
        let organs = DrawingCanvas::new(grammar, params).organs;
        return Ok(Drawing { tree, organs });
    }
    let canvas = draw_on(grammar, string, params, cancel, |params| {
        DrawingCanvas::new(grammar, params)
    })?;
    Ok(canvas.finish())
}

/// A [`TreeCanvas`] that also keeps polygons, spheres, surfaces, colours, materials and cylinders.
pub struct DrawingCanvas<'a> {
    grammar: &'a Grammar,
    skeleton: TreeCanvas<'a>,
    organs: Organs,
    /// Bytes that organs and skeleton may take together.
    limit: u64,
    /// Bytes of organs when they were last counted, and how many things were drawn since.
    counted: u64,
    nodes: u64,
}

impl<'a> DrawingCanvas<'a> {
    /// A canvas with the turtle's start.
    #[must_use]
    pub fn new(grammar: &'a Grammar, params: &TurtleParams) -> Self {
        let surfaces = grammar.surfaces.iter().map(|named| named.surface.clone());
        Self {
            grammar,
            skeleton: TreeCanvas::new(grammar, params),
            organs: Organs {
                palette: grammar.palette.clone(),
                surfaces: surfaces.collect(),
                ..Organs::default()
            },
            limit: params.limits.bytes,
            counted: 0,
            nodes: 1,
        }
    }

    /// The drawing.
    #[must_use]
    pub fn finish(self) -> Drawing {
        Drawing {
            tree: self.skeleton.finish(),
            organs: self.organs,
        }
    }

    /// Counts what an organ takes; room is made by halves, so up to half as much again.
    fn room(&mut self, by: Drawn, bytes: usize) -> Result<(), DeriveError> {
        self.counted += bytes as u64 + bytes as u64 / 2;
        if self.counted + self.nodes * NODE_BYTES <= self.limit {
            return Ok(());
        }
        let problem = DeriveProblem::TooManyOrgans {
            position: by.position,
            drawn: self.organs.len() as u64,
        };
        Err(problem.into())
    }
}

fn paint(pen: &Pen) -> Paint {
    Paint {
        colour: pen.colour,
        material: pen.material,
    }
}

impl Canvas for DrawingCanvas<'_> {
    fn root(&mut self, pen: &Pen, by: Drawn, radius: f32) -> Result<u32, DeriveError> {
        self.nodes += 1;
        self.skeleton.root(pen, by, radius)
    }

    #[inline]
    fn segment(
        &mut self,
        pen: &Pen,
        by: Drawn,
        end: DVec3,
        radius: f32,
    ) -> Result<u32, DeriveError> {
        self.nodes += 1;
        let node = self.skeleton.segment(pen, by, end, radius)?;
        if (pen.colour, pen.material) != (0, 0) {
            let more = (node as usize + 1).saturating_sub(self.organs.paints.len());
            self.room(by, more * size_of::<Paint>())?;
            self.organs.set_paint(node, paint(pen));
        }
        let cylinder = match pen.cylinder {
            Cylinder::None => return Ok(node),
            Cylinder::Begins => node,
            Cylinder::Of(first) => first,
        };
        self.room(by, size_of::<Smooth>())?;
        self.organs.smooth.push(Smooth { node, cylinder });
        Ok(node)
    }

    fn polygon(&mut self, pen: &Pen, by: Drawn, outline: Outline<'_>) -> Result<(), DeriveError> {
        let corners = outline.vertices.len();
        if corners > MOST_CORNERS {
            let problem = DeriveProblem::TooManyCorners {
                position: by.position,
                corners,
                most: MOST_CORNERS,
            };
            return Err(problem.into());
        }
        let corner = size_of::<glam::Vec3>();
        self.room(by, size_of::<Polygon>() + corners * corner)?;
        let organs = &mut self.organs;
        let Ok(first) = u32::try_from(organs.corners.len()) else {
            return self.room(by, usize::MAX / 4);
        };
        organs.polygons.push(Polygon {
            first,
            paint: paint(pen),
            birth: by.birth,
            node: outline.node,
        });
        let vertices = outline.vertices.iter();
        organs.corners.extend(vertices.map(|v| narrowed(*v)));
        Ok(())
    }

    fn sphere(&mut self, pen: &Pen, by: Drawn, radius: f64) -> Result<(), DeriveError> {
        self.room(by, size_of::<Sphere>())?;
        self.organs.spheres.push(Sphere {
            center: narrowed(pen.position),
            radius: narrow(radius),
            paint: paint(pen),
            birth: by.birth,
            node: pen.node,
        });
        Ok(())
    }

    fn surface(&mut self, pen: &Pen, by: Drawn, scale: f64) -> Result<(), DeriveError> {
        let surface = self.grammar.surface_of.get(usize::from(by.symbol));
        let Some(surface) = surface.copied().flatten() else {
            return Ok(());
        };
        self.room(by, size_of::<Placed>())?;
        self.organs.placed.push(Placed {
            surface,
            paint: paint(pen),
            position: narrowed(pen.position),
            orientation: pen.frame.as_quat().normalize(),
            scale: narrow(scale),
            birth: by.birth,
            node: pen.node,
            light: 1.0,
        });
        Ok(())
    }
}
