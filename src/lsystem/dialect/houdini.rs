//! L-Py's files.
use super::model::Model;
use super::text::Fault;
pub(super) fn read(_text: &str, model: &mut Model) {
    model.fault(Fault::new(0, "this dialect cannot be read yet"));
}
