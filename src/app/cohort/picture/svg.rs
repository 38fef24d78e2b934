//! A drawing as SVG, as far as plots need it.

use std::fmt::Write as _;

/// Where text stands towards its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::app) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing; lengths are in pixels of 1/96 inch, from the upper left corner.
#[derive(Debug, Default)]
pub(in crate::app) struct Svg {
    text: String,
}

/// Text that any reader of XML takes: what it may not hold is a blank.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => out.push(' '),
            letter if letter.is_control() => out.push(' '),
            letter => out.push(letter),
        }
    }
    out
}

impl Svg {
    /// The whole file.
    pub(in crate::app) fn finish(self, width: f64, height: f64) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.text
        )
    }

    /// Adds an element; writing into a string cannot fail.
    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.text, "{element}");
    }

    pub(in crate::app) fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: &str, width: f64) {
        let ([x1, y1], [x2, y2]) = (from, to);
        self.add(format_args!(
            "<line x1=\"{x1:.2}\" y1=\"{y1:.2}\" x2=\"{x2:.2}\" y2=\"{y2:.2}\" stroke=\"{colour}\" stroke-width=\"{width}\"/>"
        ));
    }

    pub(in crate::app) fn dot(&mut self, at: [f64; 2], radius: f64, colour: &str) {
        let [x, y] = at;
        self.add(format_args!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{colour}\" fill-opacity=\"0.75\" stroke=\"#ffffff\" stroke-width=\"0.5\"/>"
        ));
    }

    /// A closed area with a pale inside.
    pub(in crate::app) fn area(&mut self, points: &[[f64; 2]], colour: &str) {
        let mut list = String::new();
        for [x, y] in points {
            let _ = write!(list, "{x:.2},{y:.2} ");
        }
        self.add(format_args!(
            "<polygon points=\"{}\" fill=\"{colour}\" fill-opacity=\"0.18\" stroke=\"{colour}\" stroke-width=\"1\"/>",
            list.trim_end()
        ));
    }

    pub(in crate::app) fn square(&mut self, at: [f64; 2], size: f64, colour: &str) {
        let [x, y] = at;
        self.add(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{size}\" height=\"{size}\" fill=\"{colour}\"/>"
        ));
    }

    pub(in crate::app) fn text(
        &mut self,
        at: [f64; 2],
        size: f64,
        anchor: Anchor,
        colour: &str,
        text: &str,
    ) {
        let [x, y] = at;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.add(format_args!(
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{}</text>",
            escaped(text)
        ));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn names_cannot_break_out() {
        let mut svg = Svg::default();
        svg.text(
            [0.0, 0.0],
            9.0,
            Anchor::Start,
            "#000000",
            "</text><script>&\u{1}\"",
        );
        let text = svg.finish(10.0, 10.0);
        assert!(
            text.contains("&lt;/text&gt;&lt;script&gt;&amp; &quot;</text>"),
            "{text}"
        );
    }
}
