//! VTK's PolyData, as XML (`.vtp`) and in the legacy format (`.vtk`): what ParaView, PyVista, VMTK and 3D Slicer write.
//!
//! Both hold the same: points, and cells as lists of point numbers – vertices, lines, polygons and triangle strips. Polygons are cut
//! into fans and strips into triangles; vertices and lines are counted and left out; arrays of data on points and cells are passed over
//! without being looked at. A VTP file of nothing but lines with radii, as VMTK and 3D Slicer save centerlines, is a skeleton. <https://docs.vtk.org/en/latest/vtk_file_formats/index.html>
//!
//! ```text
//! xml, legacy ─▶ arrays of numbers: text | bytes | base64 | compressed blocks ─▶ points, cells ─▶ triangles
//! ```
//!
//! Why not `vtkio` (0.6.3), the crate for these files: it reads every array of a file, on one thread, into vectors as long as the file
//! says, lets a compressed block grow to whatever it holds, and binds C (xz). What Ramus takes from crates instead are the hard parts:
//! XML events (`quick-xml`), base64 (`base64`) and inflating into a slice that cannot grow (`zlib-rs`, `lz4_flex`). zlib-rs is used
//! by itself and not as flate2's back end: that would be switched for the whole program, and so change the bytes of its PNG files.

pub(super) mod cells;
pub(super) mod legacy;
pub(super) mod number;
pub(super) mod xml;
