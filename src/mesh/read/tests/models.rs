//! Models of other programs, where `RAMUS_SHARED` names the folder with `models/MODELS.md`.

use std::path::PathBuf;

use super::*;

/// Files, their formats, triangles and vertices.
const MODELS: &[(&str, Format, usize, usize)] = &[
    (
        "truth/a_tapered_tube.ply",
        Format::BinaryPly,
        26_236,
        13_120,
    ),
    ("truth/b_helix.ply", Format::BinaryPly, 66_778, 33_391),
    ("truth/c_y60.ply", Format::BinaryPly, 62_484, 31_244),
    ("truth/d_duct13.ply", Format::BinaryPly, 102_844, 51_424),
    (
        "truth/e_artery40_50k.ply",
        Format::BinaryPly,
        50_000,
        25_002,
    ),
    ("truth/e_artery40_10k.ply", Format::BinaryPly, 10_000, 5_002),
    (
        "truth/lungnoodle_airway60_80k.ply",
        Format::BinaryPly,
        80_000,
        40_002,
    ),
    (
        "real/blood_vessels_mc.ply",
        Format::BinaryPly,
        30_536,
        15_270,
    ),
    ("real/eztree_oak_medium.ply", Format::AsciiPly, 3_166, 2_780),
    ("real/eztree_ash_small.ply", Format::AsciiPly, 5_616, 3_706),
    (
        "real/vmtk_aorta-surface-open-ends.stl",
        Format::BinaryStl,
        11_887,
        6_068,
    ),
    ("real/vmtk_aorta-surface.vtp", Format::Vtp, 12_932, 6_468),
    (
        "real/vmtk_aorta-surface-two-segments.vtp",
        Format::Vtp,
        37_304,
        18_732,
    ),
    ("real/skeletor_722817260.obj", Format::Obj, 13_772, 6_582),
];

fn folder() -> Option<PathBuf> {
    let shared =
        std::env::var_os("RAMUS_SHARED").map(|shared| PathBuf::from(shared).join("models"));
    let found = shared.filter(|folder| folder.is_dir());
    if found.is_none() {
        eprintln!("skipped: RAMUS_SHARED does not name the folder with models");
    }
    found
}

#[test]
fn models_of_other_programs_have_the_counts_that_are_told_of_them() {
    let Some(folder) = folder() else { return };
    for &(name, format, triangles, vertices) in MODELS {
        let path = folder.join(name);
        let model =
            super::super::read(&path, &ReadLimits::default(), &AtomicBool::new(false)).unwrap();
        println!(
            "{name}: {} vertices, {} triangles, {format}, origin {}",
            model.mesh.positions.len(),
            model.mesh.triangles.len(),
            model.mesh.origin
        );
        assert_eq!(model.format, format, "{name}");
        assert_eq!(model.mesh.triangles.len(), triangles, "{name}");
        assert_eq!(model.mesh.positions.len(), vertices, "{name}");
    }
}
