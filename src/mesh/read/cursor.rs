//! Text, byte by byte: words and numbers, without making strings of them.

/// Longest number that is read, in bytes: the exact value of a double has 767 digits at most.
const LONGEST_NUMBER: usize = 1024;

/// Powers of ten that doubles hold exactly.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// A place in text.
pub(super) struct Cursor<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    #[inline]
    pub(super) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Passes blanks within the line.
    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        while self
            .peek()
            .is_some_and(|byte| byte != b'\n' && byte.is_ascii_whitespace())
        {
            self.at += 1;
        }
    }

    /// Passes blanks and ends of lines.
    #[inline]
    pub(super) fn skip_space(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    /// Goes to the start of the next line.
    #[inline]
    pub(super) fn skip_line(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|&byte| byte == b'\n');
        self.at = end.map_or(self.bytes.len(), |end| self.at + end + 1);
    }

    /// What stands here up to a blank.
    #[inline]
    pub(super) fn word(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..end.unwrap_or(rest.len())];
        self.at += word.len();
        word
    }

    /// The number that stands here and ends at a blank; the cursor stays where there is none.
    #[inline]
    pub(super) fn number(&mut self) -> Option<f64> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let (value, length) = quick(rest).or_else(|| slow(rest))?;
        self.at += length;
        Some(value)
    }

    /// The whole number that stands here; the cursor stays where there is none. What follows it is the caller's to judge.
    #[inline]
    pub(super) fn integer(&mut self) -> Option<i64> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let negative = rest.first() == Some(&b'-');
        let from = usize::from(negative || rest.first() == Some(&b'+'));
        let mut value = 0_u64;
        let end = digits(rest, from, &mut value);
        // More than 18 digits may not fit.
        if end == from || end - from > 18 {
            return None;
        }
        self.at += end;
        let value = i64::try_from(value).ok()?;
        Some(if negative { -value } else { value })
    }

    /// The word that stands here, quoted and fit for a message.
    pub(super) fn shown(&self) -> String {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let word = rest.iter().take_while(|byte| !byte.is_ascii_whitespace());
        let word: Vec<u8> = word.copied().take(24).collect();
        let plain = |c: char| if c.is_control() { '?' } else { c };
        let word: String = String::from_utf8_lossy(&word).chars().map(plain).collect();
        if word.is_empty() {
            return "nothing".to_owned();
        }
        format!("`{word}`")
    }
}

/// Adds the digits from a place on to a value, which wraps after 19 of them, and returns where they end.
#[inline]
fn digits(text: &[u8], mut at: usize, value: &mut u64) -> usize {
    while let Some(byte) = text.get(at)
        && byte.is_ascii_digit()
    {
        *value = value.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
        at += 1;
    }
    at
}

/// The number at the start of a text and its length, where one rounding gives it: up to 2⁵³, with or without a point, times or by a
/// power of ten that is exact (Clinger, <https://doi.org/10.1145/93542.93557>). All but a few numbers of real files are such.
#[inline]
fn quick(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let start = usize::from(negative || text.first() == Some(&b'+'));
    let mut mantissa = 0;
    let mut at = digits(text, start, &mut mantissa);
    let mut count = at - start;
    let mut exponent = 0;
    if text.get(at) == Some(&b'.') {
        let end = digits(text, at + 1, &mut mantissa);
        let places = end - at - 1;
        exponent = -i32::try_from(places).ok()?;
        count += places;
        at = end;
    }
    if count == 0 || count > 19 || mantissa > 1 << 53 {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let (power, end) = power_of_ten(text, at + 1)?;
        exponent += power;
        at = end;
    }
    if text.get(at).is_some_and(|byte| !byte.is_ascii_whitespace()) {
        return None;
    }
    let ten = *TENS.get(usize::try_from(exponent.unsigned_abs()).ok()?)?;
    let whole = mantissa as f64;
    let value = if exponent < 0 {
        whole / ten
    } else {
        whole * ten
    };
    Some((if negative { -value } else { value }, at))
}

/// The digits after an `e`, at most three, and where they end.
fn power_of_ten(text: &[u8], at: usize) -> Option<(i32, usize)> {
    let negative = text.get(at) == Some(&b'-');
    let from = at + usize::from(negative || text.get(at) == Some(&b'+'));
    let mut power = 0;
    let end = digits(text, from, &mut power);
    if !(1..=3).contains(&(end - from)) {
        return None;
    }
    let power = i32::try_from(power).ok()?;
    Some((if negative { -power } else { power }, end))
}

/// Any number that the standard library reads, and its length.
#[cold]
fn slow(text: &[u8]) -> Option<(f64, usize)> {
    let text = &text[..text.len().min(LONGEST_NUMBER)];
    let end = text.iter().position(u8::is_ascii_whitespace);
    let word = &text[..end.unwrap_or(text.len())];
    let value = str::from_utf8(word).ok()?.parse().ok()?;
    Some((value, word.len()))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Option<f64> {
        let mut cursor = Cursor::new(text.as_bytes(), 0);
        let value = cursor.number();
        assert!(value.is_some() || cursor.at == 0, "stays without a number");
        value
    }

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        for text in [
            "0",
            "-0",
            "+1",
            ".5",
            "5.",
            "36872.06250000",
            "1e22",
            "1e23",
            "1e-22",
            "1e-23",
            "9007199254740992",
            "9007199254740993",
            "123456789012345678901234567890",
            "0.30000000000000004",
            "1.7976931348623157e308",
            "4.9e-324",
            "1E+05",
            "1e0005",
        ] {
            let bits = |value: Option<f64>| value.map(f64::to_bits);
            assert_eq!(bits(read(text)), bits(text.parse().ok()), "{text}");
        }
        for text in ["", "-", ".", "e5", "1e", "1e+", "1,5", "0x10", "1.#QNAN"] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_as_the_standard_library_does(text in "[-+]?[0-9]{0,20}[.]?[0-9]{0,20}([eE][-+]?[0-9]{1,4})?") {
            let bits = |value: Option<f64>| value.map(f64::to_bits);
            prop_assert_eq!(bits(read(&text)), bits(text.parse().ok()));
        }

        #[test]
        fn any_double_comes_back(value in any::<f64>()) {
            prop_assume!(value.is_finite());
            prop_assert_eq!(read(&format!("{value:e} ")).map(f64::to_bits), Some(value.to_bits()));
        }
    }
}
