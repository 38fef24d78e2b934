//! Writes vessels of known axis as PLY files, each with its ends and its truth, for `beside_vmtk.py`: `vessels FOLDER`.

#[path = "../../../vessel/mod.rs"]
mod vessel;

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;

use ramus::mesh::write::WriteFormat;
use vessel::Vessel;

/// Ends, triangles, and what it is called.
const VESSELS: [(u32, u32, &str); 3] = [
    (40, 60_000, "vessel40_60k"),
    (40, 240_000, "vessel40_240k"),
    (300, 1_000_000, "vessel300_1M"),
];

fn main() {
    let folder = std::env::args().nth(1).expect("usage: vessels FOLDER");
    let folder = Path::new(&folder);
    for (tips, triangles, name) in VESSELS {
        let vessel = Vessel::new(tips);
        let to = File::create(folder.join(format!("{name}.ply"))).unwrap();
        let mut to = BufWriter::new(to);
        WriteFormat::Ply
            .write(&vessel.mesh(triangles), &mut to)
            .unwrap();
        to.flush().unwrap();
        fs::write(folder.join(format!("{name}.seeds.json")), seeds(&vessel)).unwrap();
        fs::write(folder.join(format!("{name}.skeleton.json")), truth(&vessel)).unwrap();
    }
}

fn seeds(vessel: &Vessel) -> String {
    let targets = vessel.targets().into_iter().map(|one| one.to_array());
    format!(
        "{{\"source\": {:?}, \"targets\": {:?}}}\n",
        vessel.source().to_array(),
        targets.collect::<Vec<_>>()
    )
}

fn truth(vessel: &Vessel) -> String {
    let nodes = vessel.nodes.iter().map(|node| node.to_array());
    let parents = vessel.parents.iter();
    let parents = parents.map(|parent| parent.map_or("-1".to_owned(), |parent| parent.to_string()));
    format!(
        "{{\"nodes\": {:?}, \"parent\": [{}], \"radius\": {:?}}}\n",
        nodes.collect::<Vec<_>>(),
        parents.collect::<Vec<_>>().join(", "),
        vessel.radii
    )
}
