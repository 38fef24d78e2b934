//! Numbers as C's `printf("%.10g")` writes them, which is how every L-system program prints parameters.

use std::fmt::Write as _;

/// Significant digits.
const DIGITS: usize = 10;

/// Appends `value` as `%.10g`: ten significant digits, trailing zeros removed, exponents outside −4…9 in `e` notation.
pub(crate) fn write_general(text: &mut String, value: f64) {
    // Most parameters are whole numbers: no need to go by digits.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the value is whole and below 1e9"
    )]
    if value.fract() == 0.0 && value.abs() < 1e9 && !(value == 0.0 && value.is_sign_negative()) {
        let _ = write!(text, "{}", value as i64);
        return;
    }
    if !value.is_finite() {
        text.push_str(if value.is_nan() {
            "nan"
        } else if value > 0.0 {
            "inf"
        } else {
            "-inf"
        });
        return;
    }
    // `{:e}` rounds to the nearest even digit as C does; "d.ddddddddde-7".
    let scientific = format!("{value:.*e}", DIGITS - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let (sign, mantissa) = mantissa
        .strip_prefix('-')
        .map_or(("", mantissa), |m| ("-", m));
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let digits = digits.trim_end_matches('0');
    let digits = if digits.is_empty() { "0" } else { digits };
    text.push_str(sign);
    if exponent < -4 || exponent >= i32::try_from(DIGITS).unwrap_or(i32::MAX) {
        let (first, rest) = digits.split_at(1);
        text.push_str(first);
        if !rest.is_empty() {
            text.push('.');
            text.push_str(rest);
        }
        let mark = if exponent < 0 { '-' } else { '+' };
        let _ = write!(text, "e{mark}{:02}", exponent.unsigned_abs());
    } else if exponent < 0 {
        text.push_str("0.");
        for _ in 1..exponent.unsigned_abs() {
            text.push('0');
        }
        text.push_str(digits);
    } else {
        let whole = exponent.unsigned_abs() as usize + 1;
        if digits.len() <= whole {
            text.push_str(digits);
            for _ in digits.len()..whole {
                text.push('0');
            }
        } else {
            let (before, after) = digits.split_at(whole);
            text.push_str(before);
            text.push('.');
            text.push_str(after);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected texts were made with C's printf.
    #[test]
    fn as_c_prints() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (-17.0, "-17"),
            (0.5, "0.5"),
            (1.0 / 3.0, "0.3333333333"),
            (2.0_f64.sqrt(), "1.414213562"),
            (0.0001, "0.0001"),
            (0.00001, "1e-05"),
            (0.000_012_345_678_901_23, "1.23456789e-05"),
            (123_456_789.0, "123456789"),
            (1_234_567_890.0, "1234567890"),
            (9_999_999_999.0, "9999999999"),
            (99_999_999_999.0, "1e+11"),
            (1e10, "1e+10"),
            (9_999_999_999.5, "1e+10"),
            (9_999_999_998.5, "9999999998"),
            (12_345_678_901.0, "1.23456789e+10"),
            (1e100, "1e+100"),
            (-1.5e-300, "-1.5e-300"),
            (f64::MAX, "1.797693135e+308"),
            (5e-324, "4.940656458e-324"),
            (0.1 + 0.2, "0.3"),
            (100.0, "100"),
            (1e9, "1000000000"),
            (1_000_000_000.25, "1000000000"),
            (137.507_764_050_037_85, "137.5077641"),
        ] {
            let mut text = String::new();
            write_general(&mut text, value);
            assert_eq!(text, expected, "{value:e}");
        }
    }

    /// 400 numbers of all kinds whose texts C's printf made.
    #[test]
    fn as_c_printed_into_a_file() {
        let mut checked = 0;
        let lines = include_str!("../../tests/data/numbers.txt").lines();
        for line in lines.filter(|l| !l.starts_with('#')) {
            let (bits, expected) = line.split_once(' ').unwrap_or_default();
            let value = f64::from_bits(u64::from_str_radix(bits, 16).unwrap_or(0));
            let mut text = String::new();
            write_general(&mut text, value);
            assert_eq!(text, expected, "{value:e}");
            checked += 1;
        }
        assert!(checked > 300, "only {checked} numbers");
    }
}
