//! The journal of edits: no bytes may stop its reader, and no order of actions may stop its replay.
//!
//! Each line carries a checksum over all before it, which a fuzzer cannot guess. So the input is read
//! twice: as a journal, and as bare actions, one a line, from which a whole journal is written first.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::world::{document::Document, history::Action, journal};

fuzz_target!(|bytes: &[u8]| {
    let base = Document::default();
    if let Ok(decoded) = journal::decode(bytes) {
        assert!(decoded.whole_bytes <= bytes.len(), "no more is whole than is there");
        let _ = journal::recover(&decoded);
    }

    let (mut writer, mut text) = journal::Journal::begin(&base);
    let mut count = 0;
    for line in bytes.split(|byte| *byte == b'\n').take(64) {
        if let Ok(action) = serde_json::from_slice::<Action>(line) {
            text.push_str(&writer.line(&action));
            count += 1;
        }
    }
    let decoded = journal::decode(text.as_bytes()).expect("what was written can be read");
    assert!(decoded.actions.len() <= count, "no action comes from nowhere");
    let mut recovered = journal::recover(&decoded);
    let done = ramus::world::project::to_bytes(recovered.history.committed());
    ramus::world::project::from_bytes(&done).expect("actions leave a document that can be read");
    while recovered.history.undo() {}
    assert_eq!(
        ramus::world::project::to_bytes(recovered.history.committed()),
        ramus::world::project::to_bytes(&base),
        "undo to the start gives the start"
    );
});
