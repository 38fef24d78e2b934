//! Made-up sources with what is wrong in them.

/// The checker on made-up sources: the file, its text, and a part of each complaint in order.
pub(crate) const MADE_UP: &[(&str, &str, &[&str])] = &[
    // What is allowed.
    (
        "world/tools.rs",
        "use crate::{sketch::Sketch, tree::Tree};",
        &[],
    ),
    (
        "render/frame.rs",
        "use crate::world::scene::{Rod, Scene}; use ash::vk;",
        &[],
    ),
    (
        "render/frame.rs",
        "use crate::{tree::Tree, world::{scene::Scene}};",
        &[],
    ),
    (
        "cli/mod.rs",
        "use crate::{app, lsystem, render, ui, world::input};",
        &[],
    ),
    (
        "tree/export.rs",
        "// use crate::app;\n/* crate::render /* crate::ui */ */",
        &[],
    ),
    (
        "tree/export.rs",
        r##"const A: &str = "crate::render"; const B: &str = r#"crate::"ui"#;"##,
        &[],
    ),
    (
        "tree/export.rs",
        "fn f<'a>(x: &'a str) -> char { '\"' } use super::tubes;",
        &[],
    ),
    (
        "tree/mod.rs",
        "mod tests { use super::*; fn f() { super::super::tree::new() } }",
        &[],
    ),
    (
        "ui/board.rs",
        "struct A { ash: u32 } fn f(a: A) -> u32 { a.ash }",
        &[],
    ),
    ("sketch/mod.rs", "#![deny(unsafe_code)]", &[]),
    // What is not.
    (
        "tree/mod.rs",
        "use crate::lsystem;",
        &["src/tree/mod.rs:1: tree reaches up to lsystem"],
    ),
    (
        "lsystem/mod.rs",
        "use crate::mesh::Mesh;",
        &["lsystem reaches up to mesh"],
    ),
    (
        "sketch/mod.rs",
        "use crate::{\n    tree::Tree,\n    world::{input, scene},\n    app,\n};",
        &[
            ":3: sketch reaches up to world",
            ":3: sketch reaches up to world",
            ":4: sketch reaches up to app",
        ],
    ),
    (
        "world/hover.rs",
        "fn f() { let x = ramus::render::new(); }",
        &["world reaches up to render"],
    ),
    (
        "tree/import.rs",
        "use super::super::world::input;",
        &["tree reaches up to world"],
    ),
    (
        "tree/mod.rs",
        "mod tests {\n use super::super::ui;\n}",
        &[":2: tree reaches up to ui"],
    ),
    (
        "ui/mod.rs",
        "use crate::render::Gpu;",
        &["ui reaches up to render"],
    ),
    (
        "render/mod.rs",
        "use crate::world::World;",
        &["render sees of world only"],
    ),
    (
        "render/mod.rs",
        "use crate::world;",
        &["render sees of world only"],
    ),
    (
        "render/mod.rs",
        "use crate::world::{scene, tools};",
        &["not Some(\"tools\")"],
    ),
    (
        "render/mod.rs",
        "use ramus_xr::Frame;",
        &["must not name ramus_xr"],
    ),
    (
        "render/mod.rs",
        "use ramus_xr::{vulkan::VulkanHost, Frame};",
        &["must not name ramus_xr"],
    ),
    ("render/mod.rs", "use ramus_xr::vulkan::VulkanHost;", &[]),
    (
        "ui/mod.rs",
        "use ramus_xr::vulkan::VulkanHost;",
        &["must not name ramus_xr"],
    ),
    ("world/mod.rs", "use egui;", &["must not name egui"]),
    (
        "world/mod.rs",
        "fn f(x: ash::vk::Image) {}",
        &["must not name ash"],
    ),
    (
        "lsystem/mod.rs",
        "pub use ::openxr as xr;",
        &["must not name openxr"],
    ),
    (
        "lsystem/mod.rs",
        "extern crate winit;",
        &["must not name winit"],
    ),
    ("sketch/a/b.rs", "unsafe { x() }", &["unsafe belongs"]),
    ("attic/mod.rs", "", &["attic is no room yet"]),
];
