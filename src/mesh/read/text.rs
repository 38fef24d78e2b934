//! Text in pieces, to be understood by all threads.

/// Length of a piece, in bytes: some milliseconds of work.
const LENGTH: usize = 512 << 10;

/// A part of a text.
pub(super) struct Piece<'a> {
    /// Where it begins in the text.
    pub(super) at: usize,
    pub(super) text: &'a [u8],
}

/// Cuts a text at starts of lines before which it may be cut: the caller is asked at each. Without any there is one piece.
pub(super) fn pieces(text: &[u8], may_begin: impl Fn(&[u8], usize) -> bool) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let end = end(text, at.saturating_add(LENGTH), &may_begin);
        let text = &text[at..end];
        pieces.push(Piece { at, text });
        at = end;
    }
    pieces
}

/// The first start of a line from a place on at which a piece may begin.
fn end(text: &[u8], mut at: usize, may_begin: &impl Fn(&[u8], usize) -> bool) -> usize {
    while let Some(rest) = text.get(at..) {
        let Some(line) = rest.iter().position(|&byte| byte == b'\n') else {
            break;
        };
        at += line + 1;
        if may_begin(text, at) {
            return at;
        }
    }
    text.len()
}
