//! The reader of SWC files: no bytes may stop it, and what it read is a tree that can be written.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::tree::{TreeError, export, import};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(tree) = import::swc(bytes) {
        tree.validate().expect("what was read is a whole tree");
        let written = match export::swc(&tree) {
            Ok(written) => written,
            // Files may hold several trees or a lone node; written is one tree with a segment at least.
            Err(TreeError::Empty(_) | TreeError::ManyRoots(_)) => return,
            Err(other) => panic!("what was read cannot be written: {other}"),
        };
        let again = import::swc(&written).expect("what was written can be read");
        assert_eq!(tree.parent.len(), again.parent.len(), "no node is lost");
    }
});
