//! Models of other programs, where `RAMUS_SHARED` names the folder with `models/MODELS.md`.

use super::*;
use crate::mesh::{ReadLimits, read};

fn model(name: &str) -> Option<Mesh> {
    let Some(shared) = std::env::var_os("RAMUS_SHARED") else {
        eprintln!("skipped: RAMUS_SHARED does not name the folder with models");
        return None;
    };
    let path = std::path::Path::new(&shared).join("models").join(name);
    let never = AtomicBool::new(false);
    Some(read(&path, &ReadLimits::default(), &never).unwrap().mesh)
}

#[test]
fn an_aorta_with_open_ends_is_closed() {
    let Some(aorta) = model("real/vmtk_aorta-surface-open-ends.stl") else {
        return;
    };
    let open = look(&aorta);
    assert_eq!(open.boundary_loops.len(), 3);
    for list in [
        "close",
        "close=smooth",
        "orient,close,decimate=2000",
        "close=smooth,remesh=0.8",
        "close,smooth",
    ] {
        let (closed, told) = mended(&aorta, list);
        println!("{list}: {told:?}");
        let report = look(&closed);
        assert_eq!(facts(&closed), (true, true, Some(0), 1, 0), "{list}");
        assert!(report.inconsistent_edges.is_empty() && is_clean(&closed));
        let volume = report.components[0].signed_volume.unwrap();
        println!(
            "{list}: encloses {volume}, area {} of {}",
            report.area(),
            open.area()
        );
        // The file has its triangles inside out.
        assert_eq!(volume > 0.0, list.contains("orient"), "{list}");
    }
}

#[test]
fn a_neuron_of_64_components_becomes_one() {
    let Some(neuron) = model("real/skeletor_722817260.obj") else {
        return;
    };
    let before = look(&mended(&neuron, "weld").0);
    assert_eq!(before.components.len(), 64);
    let (kept, told) = mended(&neuron, "debris");
    println!("{told:?}");
    assert!(look(&kept).components.len() < 64);
    for list in [
        "largest",
        "weld,largest,orient,close",
        "largest,decimate=3000",
        "largest,remesh=1%",
        "largest,close=smooth,smooth",
    ] {
        let (one, told) = mended(&neuron, list);
        println!("{list}: {told:?}");
        let after = look(&one);
        assert_eq!(after.components.len(), 1, "{list}");
        assert!(
            after.non_manifold_edges.len() <= before.non_manifold_edges.len(),
            "{list}"
        );
        assert!(is_clean(&one));
    }
}

#[test]
fn trees_of_open_tubes_and_steps_of_voxels_are_mended() {
    for (name, lists) in [
        (
            "real/eztree_oak_medium.ply",
            ["weld=0.01%,orient,close", "orient,close=smooth"],
        ),
        (
            "real/blood_vessels_mc.ply",
            ["smooth=20,close,decimate=25%", "close=smooth,remesh=0.5%"],
        ),
        ("truth/e_artery40_10k.ply", ["decimate=10%", "remesh=0.4%"]),
    ] {
        let Some(mesh) = model(name) else { return };
        let before = look(&mended(&mesh, "weld").0);
        for list in lists {
            let (after, told) = mended(&mesh, list);
            println!("{name} {list}: {told:?}");
            let report = look(&after);
            assert!(is_clean(&after), "{name} {list}");
            assert!(
                report.non_manifold_edges.len() <= before.non_manifold_edges.len(),
                "{name} {list}"
            );
            if list.contains("close") {
                assert!(
                    report
                        .boundary_loops
                        .iter()
                        .all(|end| !end.closed || end.edges() == 3),
                    "{name} {list}"
                );
            } else {
                assert_eq!(report.euler_characteristic(), before.euler_characteristic());
            }
        }
    }
}
