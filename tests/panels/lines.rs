//! Centerlines in the session: found beside it, seen inside the model, listed, lit from the panel and from the model, written, stopped.

use std::path::Path;
use std::time::Instant;

use glam::Vec3;
use image::imageops::{FilterType, crop_imm, resize};
use image::{DynamicImage, RgbImage, RgbaImage};
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::store::Store;
use ramus::app::workshop::{Workshop, WorkshopParams};
use ramus::mesh::unit::Rounded;
use ramus::world::DrawTool;
use ramus::world::lines::{LineLook, Lines, Quantity};
use ramus::world::panels::PanelId;
use ramus::world::scene::SurfaceLook;

use super::guide::{compare, strip};
use super::models::{ALONG, ROUND, press, tube, vessel, visitor};
use super::pictures::{draw, save, views};
use super::visitor::{RIGHT, Visitor};

/// The only model's centerlines.
fn lines(visitor: &Visitor) -> &Lines {
    let model = &visitor.document().models[0];
    visitor.workshop.world().lines(model).unwrap().unwrap()
}

/// The branch that is lit.
fn lit(visitor: &Visitor) -> Option<usize> {
    let model = &visitor.document().models[0];
    visitor.workshop.world().lit_branch(model)
}

/// How the table has a branch's length.
fn length(visitor: &Visitor, branch: usize) -> String {
    Rounded(lines(visitor).analysis.branches[branch].length).to_string()
}

/// The middle node of a branch, on the stage.
fn place_of(visitor: &Visitor, branch: usize) -> Vec3 {
    let model = &visitor.document().models[0];
    let loaded = visitor.workshop.world().loaded_model(model).unwrap();
    let lines = lines(visitor);
    let node = lines.nodes_of(branch);
    let node = node[node.len() / 2];
    let shift = lines.centerline.origin - loaded.plain.mesh.origin;
    let at = lines.centerline.tree.position[node as usize] + shift.as_vec3();
    let map = loaded.stage_from_model(model);
    map.transform_point3(at)
}

fn says(visitor: &Visitor, part: &str) -> bool {
    let mut texts = visitor.workshop.texts(PanelId::Bench);
    texts.any(|text| text.contains(part))
}

/// Pixels of the colour in which branches are lit, and their middle.
fn lights(picture: &RgbaImage) -> (usize, [f32; 2]) {
    let is = |[red, green, blue, _]: [u8; 4]| red > 140 && green < 80 && blue > 80;
    let (mut count, mut sum) = (0, [0.0; 2]);
    for (x, y, _) in picture.enumerate_pixels().filter(|pixel| is(pixel.2.0)) {
        count += 1;
        sum = [sum[0] + x as f32, sum[1] + y as f32];
    }
    (count, sum.map(|sum| sum / count.max(1) as f32))
}

/// The left and the right eye's half of what they see together.
fn eyes(both: &RgbaImage) -> [RgbaImage; 2] {
    let (width, height) = (both.width() / 2, both.height());
    [0, width].map(|from| crop_imm(both, from, 0, width, height).to_image())
}

/// Somebody before a vessel whose centerlines are found.
fn with_lines(folder: &Path) -> Visitor {
    vessel(folder);
    let mut visitor = visitor(folder);
    for text in ["Models", "vessel.obj", "Centerlines", "Find centerlines"] {
        press(&mut visitor, text);
    }
    visitor
}

#[test]
fn centerlines_are_found_listed_and_lit_from_the_panel_and_from_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = with_lines(folder.path());
    let model = visitor.document().models[0].clone();
    assert_eq!(model.surface, Some(SurfaceLook::XRay), "seen through");
    assert_eq!(model.lines, Some(LineLook::default()));
    let counts = lines(&visitor).analysis.counts;
    assert_eq!((counts.branches, counts.junctions, counts.tips), (3, 1, 2));
    assert!(says(&visitor, "branches: 3, forks: 1, tips: 2"));
    // The ends were proposed, which is shown, and no edit.
    assert_eq!(visitor.workshop.world().proposals(&model).len(), 3);
    assert_eq!(
        visitor.workshop.edits(),
        2,
        "brought, and shown with its lines"
    );

    let place = model.place.position;
    let near = views(place + Vec3::new(0.0, 0.25, 0.75), place + Vec3::Y * 0.2);
    let dark = eyes(&draw(&mut visitor, &mut picture, &near));
    assert_eq!(dark.each_ref().map(lights).map(|(count, _)| count), [0, 0]);

    // A row lights its branch, in both eyes, where it is.
    let mut middles = Vec::new();
    for branch in 0..3 {
        let row = length(&visitor, branch);
        press(&mut visitor, &row);
        assert_eq!(lit(&visitor), Some(branch));
        let seen = draw(&mut visitor, &mut picture, &near);
        save(&seen, &format!("lines-lit-{branch}.png"));
        let [(left, a), (right, b)] = eyes(&seen).each_ref().map(lights);
        assert!(left > 150 && right > 150, "{branch}: {left} {right}");
        // What is before the eyes is farther right in the left one's picture.
        assert!(
            a[0] > b[0] + 5.0 && (a[1] - b[1]).abs() < 4.0,
            "{a:?} {b:?}"
        );
        middles.push(a);
    }
    // The stem is below, one tip above it and the other to the right.
    let [stem, up, aside] = &middles[..] else {
        panic!("{middles:?}");
    };
    let (up, aside) = if up[0] < aside[0] {
        (up, aside)
    } else {
        (aside, up)
    };
    assert!(
        stem[1] > up[1] + 60.0 && aside[0] > up[0] + 60.0,
        "{middles:?}"
    );
    let row = length(&visitor, 2);
    press(&mut visitor, &row);
    assert_eq!(lit(&visitor), None, "pressed once more it goes out");

    // The other way round: the ray on a branch, and the trigger.
    press(&mut visitor, "chooses branches");
    assert_eq!(visitor.workshop.world().settings().tool, DrawTool::Branch);
    let at = place_of(&visitor, 1);
    visitor.tip_to(RIGHT, at + Vec3::Z * 0.4);
    let label = format!("1: {} mm", length(&visitor, 1));
    visitor.frame();
    assert!(visitor.says(PanelId::Label, &label), "{label}");
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert_eq!(lit(&visitor), Some(1));
    assert!(visitor.document().sketch.is_empty(), "nothing is drawn");
    let plot = "branch 1: radius along the way through it";
    visitor.scroll_to(RIGHT, PanelId::Bench, plot);
    assert_eq!(visitor.workshop.edits(), 2, "light is no edit");

    // Undo takes centerlines back with what made the model seen through.
    visitor.rest(RIGHT);
    visitor.frame.hands[RIGHT].stick.x = -1.0;
    visitor.frame();
    visitor.frame.hands[RIGHT].stick.x = 0.0;
    visitor.frame();
    let model = visitor.document().models[0].clone();
    assert_eq!(
        (model.lines, model.surface),
        (None, Some(SurfaceLook::Shaded))
    );
    assert_eq!(visitor.workshop.scene().models.len(), 1);
    visitor.frame.hands[RIGHT].stick.x = 1.0;
    visitor.frame();
    visitor.workshop.finish_models();
    assert_eq!(lines(&visitor).len(), 3);
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn a_project_shows_its_centerlines_when_it_is_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = with_lines(folder.path());
    press(&mut visitor, "volume");
    let table = lines(&visitor).analysis.table;
    visitor.workshop.close().unwrap();
    let opened = Store::open(&folder.path().join("a.ramus")).unwrap();
    let mut again = Workshop::new(opened, WorkshopParams::default()).unwrap();
    assert!(again.is_reading());
    again.finish_models();
    let model = again.document().models[0].clone();
    let by = Some(Quantity::Volume);
    assert_eq!(
        model.lines,
        Some(LineLook {
            by,
            ..LineLook::default()
        })
    );
    let found = again.world().lines(&model).unwrap().unwrap();
    let same = found.analysis.table.branch_length == table.branch_length;
    assert!(same, "found anew, and the same");
    assert_eq!(again.world().shading(&model).unwrap().by, by);
    assert_eq!(again.scene().models.len(), 2);
}

#[test]
fn centerlines_are_sorted_coloured_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut visitor = with_lines(folder.path());
    // Rows lie in the order of a column: the first one is pressed.
    let first = |visitor: &mut Visitor| {
        let heads = [0, 1, 2].map(|branch| length(visitor, branch));
        let at = heads.map(|text| visitor.find(PanelId::Bench, &text).y);
        (0..3).min_by(|a, b| at[*a].total_cmp(&at[*b])).unwrap()
    };
    visitor.scroll_to(RIGHT, PanelId::Bench, "colour by");
    assert_eq!(first(&mut visitor), 0);
    let by_length = |visitor: &Visitor, a: usize, b: usize| {
        let branches = &lines(visitor).analysis.branches;
        branches[a].length.total_cmp(&branches[b].length)
    };
    // The head of the column is the first that says so; "length" is also a colour, farther down.
    visitor.click(RIGHT, PanelId::Bench, "length");
    let shortest = (0..3).min_by(|a, b| by_length(&visitor, *a, *b)).unwrap();
    assert_eq!(first(&mut visitor), shortest);
    visitor.click(RIGHT, PanelId::Bench, "length +");
    let longest = (0..3).max_by(|a, b| by_length(&visitor, *a, *b)).unwrap();
    assert_eq!(first(&mut visitor), longest);

    for (text, by) in [
        ("radius at each place", Quantity::RadiusHere),
        ("Strahler", Quantity::Strahler),
        ("volume", Quantity::Volume),
    ] {
        press(&mut visitor, text);
        let model = visitor.document().models[0].clone();
        assert_eq!(model.lines.unwrap().by, Some(by));
        let shading = visitor.workshop.world().shading(&model).unwrap();
        assert_eq!(shading.by, Some(by));
        let [low, high] = shading.range.unwrap();
        assert!(low < high, "{text} {low} {high}");
    }
    press(&mut visitor, "largest balls within");
    assert_eq!(visitor.workshop.scene().models.len(), 3);

    for ending in ["SWC", "VTP", "GLB", "CSV", "JSON"] {
        press(&mut visitor, ending);
        visitor.workshop.finish_tree();
        let file = format!("vessel-lines-1.{}", ending.to_lowercase());
        let bytes = std::fs::read(folder.path().join(&file)).unwrap();
        assert!(bytes.len() > 200, "{file}");
    }
    let read = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();
    let table = read("vessel-lines-1.csv");
    let rows = |of: &str| table.lines().filter(|row| row.starts_with(of)).count();
    assert_eq!(
        ["branches,", "branches_vmtk,", "centerlines,"].map(rows),
        [3, 3, 2],
        "{table}"
    );
    let json: serde_json::Value = serde_json::from_str(&read("vessel-lines-1.json")).unwrap();
    assert_eq!(json["format"], "ramus-analysis/1");
    assert_eq!(json["model"]["unit"], "millimetres");
    assert_eq!(json["counts"]["branches"], 3);
    assert_eq!(json["endpoints"]["automatic"], true);
}

/// A press that waits for nothing.
fn touch(visitor: &mut Visitor, text: &str) {
    visitor.scroll_to(RIGHT, PanelId::Bench, text);
    visitor.click(RIGHT, PanelId::Bench, text);
}

#[test]
fn the_search_goes_on_beside_the_session_and_can_be_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    // A comb: enough ends and triangles for a search that is seen.
    tube(&mut text, 1, |t| Vec3::Y * 320.0 * t, |_| 11.0);
    for tooth in 0..20_u8 {
        let from = Vec3::Y * (20.0 + 14.0 * f32::from(tooth));
        let first = 1 + ROUND * (ALONG + 1) * (usize::from(tooth) + 1);
        let side = if tooth % 2 == 0 { 1.0 } else { -1.0 };
        let path = move |t: f32| from + Vec3::new(60.0 * side * t, 8.0 * t, 0.0);
        tube(&mut text, first, path, |_| 4.0);
    }
    std::fs::write(folder.path().join("comb.obj"), text).unwrap();
    let mut visitor = visitor(folder.path());
    for text in ["Models", "comb.obj", "Centerlines"] {
        press(&mut visitor, text);
    }
    visitor.scroll_to(RIGHT, PanelId::Bench, "Find centerlines");
    let before = visitor.frames.len();
    let began = Instant::now();
    visitor.click(RIGHT, PanelId::Bench, "Find centerlines");
    let frames = visitor.frames.len() - before;
    println!("{frames} frames took {:?}", began.elapsed());
    assert!(visitor.workshop.world().finding().is_some());
    assert!(says(&visitor, "looking for centerlines: "));
    touch(&mut visitor, "Cancel");
    let model = visitor.document().models[0].clone();
    let world = visitor.workshop.world();
    let why = world.lines(&model).unwrap().unwrap_err();
    assert_eq!(why, "Stopped looking for the centerlines of comb.obj.");
    assert!(world.finding().is_none() && world.wanted_lines().is_none());
    assert!(says(&visitor, "Stopped looking"));
    // What is taken away while it is looked for says nothing afterwards.
    touch(&mut visitor, "Try again");
    assert!(visitor.workshop.world().finding().is_some());
    touch(&mut visitor, "Take the centerlines away");
    assert!(visitor.workshop.world().finding().is_none());
    visitor.workshop.finish_models();
    let model = visitor.document().models[0].clone();
    assert!(visitor.workshop.world().lines(&model).is_none());
    // Left alone it comes to its end, with all that was seen on the way.
    touch(&mut visitor, "Find centerlines");
    let mut seen = Vec::new();
    while let Some(finding) = visitor.workshop.world().finding() {
        seen.push(finding.percent);
        visitor.frame();
        visitor.frames.clear();
    }
    seen.dedup();
    assert!(seen.is_sorted() && seen.len() >= 3, "{seen:?}");
    let counts = lines(&visitor).analysis.counts;
    assert!((16..=21).contains(&counts.tips), "{counts:?}");
    // More rows than are seen: the one of a branch that is chosen in the model is scrolled to.
    let last = lines(&visitor).len() - 1;
    assert!(last > 25, "orders are not so large: {last}");
    press(&mut visitor, "chooses branches");
    visitor.scroll_to(RIGHT, PanelId::Bench, "colour by");
    let seen = |visitor: &Visitor, branch: usize| {
        let row = visitor
            .workshop
            .find_text(PanelId::Bench, &branch.to_string(), 1);
        row.is_some()
    };
    // Scrolled to its end, and then sorted the other way round.
    assert!(seen(&visitor, last));
    visitor.click(RIGHT, PanelId::Bench, "branch +");
    assert!(!seen(&visitor, last), "it is far up");
    let at = place_of(&visitor, last);
    visitor.tip_to(RIGHT, at + Vec3::Z * 0.3);
    visitor.pull(RIGHT, true);
    visitor.pull(RIGHT, false);
    assert_eq!(lit(&visitor), Some(last));
    assert!(seen(&visitor, last), "its row is there");
}

#[test]
fn what_is_wrong_is_told_and_what_is_not_reached_is_marked() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    tube(&mut text, 1, |t| Vec3::Y * 100.0 * t, |_| 8.0);
    let beside = |t: f32| Vec3::new(40.0, 100.0 * t, 0.0);
    tube(&mut text, 1 + ROUND * (ALONG + 1), beside, |_| 8.0);
    std::fs::write(folder.path().join("two.obj"), text).unwrap();
    let ends = |name: &str, rows: &str| {
        std::fs::write(folder.path().join(name), format!("name,kind,x,y,z\n{rows}")).unwrap();
    };
    ends("none.csv", "a,target,0,5,7\nb,target,0,95,7\n");
    ends(
        "ends.csv",
        "a,source,0,5,7\nb,target,0,95,7\nfar,target,40,95,7\n",
    );
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = visitor(folder.path());
    for text in [
        "Models",
        "two.obj",
        "Places",
        "none.csv",
        "Centerlines",
        "Find centerlines",
    ] {
        press(&mut visitor, text);
    }
    assert!(says(&visitor, "there is no source: give one"));
    assert!(visitor.workshop.world().has_message(), "on the board, too");
    assert!(!visitor.workshop.is_reading(), "it is not tried for ever");
    let place = visitor.document().models[0].place.position;
    let near = views(place + Vec3::new(0.0, 0.25, 0.75), place + Vec3::Y * 0.2);
    let before = draw(&mut visitor, &mut picture, &near);
    // Other endpoints: it is looked for by itself.
    for text in ["Places", "ends.csv", "Centerlines"] {
        press(&mut visitor, text);
    }
    assert_eq!(lines(&visitor).len(), 1);
    for told in [
        "Not reached: 1",
        "far: not connected to the source: gap of ",
    ] {
        assert!(says(&visitor, told), "{told}");
    }
    let after = draw(&mut visitor, &mut picture, &near);
    save(&after, "lines-unreached.png");
    let orange = |picture: &RgbaImage| {
        let is =
            |[red, green, blue, _]: [u8; 4]| red > 170 && (60..150).contains(&green) && blue < 60;
        picture.pixels().filter(|pixel| is(pixel.0)).count()
    };
    let [before, after] = [&before, &after].map(orange);
    assert!(after > before + 60, "{before} {after}");
    press(&mut visitor, "Room");
    press(&mut visitor, "Deutsch");
    press(&mut visitor, "Modelle");
    let told = "far: nicht mit der Quelle verbunden: Lücke von";
    assert!(says(&visitor, told));
    let middle = visitor.center(PanelId::Bench);
    let bench = views(middle + visitor.normal(PanelId::Bench) * 0.62, middle);
    for (text, name) in [("wählt Zweige", "table"), ("JSON", "summary")] {
        visitor.scroll_to(RIGHT, PanelId::Bench, text);
        let seen = draw(&mut visitor, &mut picture, &bench);
        save(&seen, &format!("bench-lines-{name}-de.png"));
    }
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn the_guide_shows_centerlines_in_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 720, 720).unwrap();
    let mut visitor = with_lines(folder.path());
    let place = visitor.document().models[0].place.position;
    let near = views(
        place + Vec3::new(-0.1, 0.2, 0.55),
        place + Vec3::new(0.03, 0.2, 0.0),
    );
    let middle = visitor.center(PanelId::Bench);
    let bench = views(middle + visitor.normal(PanelId::Bench) * 0.62, middle);
    let mut still = |visitor: &mut Visitor, views| -> RgbImage {
        let [left, _] = eyes(&draw(visitor, &mut picture, views));
        DynamicImage::ImageRgba8(resize(&left, 360, 360, FilterType::Triangle)).to_rgb8()
    };
    press(&mut visitor, "radius at each place");
    press(&mut visitor, "largest balls within");
    let coloured = still(&mut visitor, &near);
    press(&mut visitor, "largest balls within");
    let row = length(&visitor, 1);
    press(&mut visitor, &row);
    visitor.scroll_to(RIGHT, PanelId::Bench, "chooses branches");
    let chosen = still(&mut visitor, &near);
    let table = still(&mut visitor, &bench);
    visitor.scroll_to(RIGHT, PanelId::Bench, "All together");
    visitor.scroll_to(RIGHT, PanelId::Bench, "JSON");
    let plots = still(&mut visitor, &bench);
    compare(
        "models/session-lines",
        &strip(&[coloured, chosen, table, plots]),
    );
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}

#[test]
fn gaps_are_bridged_and_lines_go_on_to_open_ends_from_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    let from = |start: f32| move |t: f32| Vec3::Y * (start + 100.0 * t);
    tube(&mut text, 1, from(0.0), |_| 10.0);
    tube(&mut text, 1 + ROUND * (ALONG + 1), from(103.0), |_| 10.0);
    std::fs::write(folder.path().join("broken.obj"), text).unwrap();
    let mut visitor = visitor(folder.path());
    for text in ["Models", "broken.obj", "Centerlines", "Find centerlines"] {
        press(&mut visitor, text);
    }
    assert!(says(&visitor, "Not reached: 2"));
    let mut texts = visitor.workshop.texts(PanelId::Bench);
    let width = texts.find(|text| text.contains("gap of"));
    assert!(
        width
            .as_ref()
            .is_some_and(|text| text.contains("gap of 2.998")),
        "{width:?}"
    );
    drop(texts);
    let whole = |visitor: &Visitor| lines(visitor).centerline.tree.total_length();
    let one = whole(&visitor);
    press(&mut visitor, "4.06 mm");
    let look = visitor.document().models[0].lines.unwrap();
    assert_eq!(look.bridge, Some(20));
    assert!(!says(&visitor, "Not reached"));
    let both = whole(&visitor);
    assert!(one < 100.0 && both > 180.0, "{one} {both}");
    press(&mut visitor, "on to the middle of open ends");
    let capped = whole(&visitor);
    assert!(
        capped > both + 10.0 && (capped - 203.0).abs() < 0.5,
        "{both} {capped}"
    );
    press(&mut visitor, "on to the middle of open ends");
    assert!((whole(&visitor) - both).abs() < 1e-6);
    press(&mut visitor, "nothing");
    assert!(says(&visitor, "Not reached: 2"));
}
