//! A comparison as files: a table (CSV), a page of plots (SVG) and a picture (PNG).

mod page;
mod picture;

use crate::app::table::{Cell, Column, Kind, Table};
use crate::tree::compare::Studied;
use crate::tree::compare::numbers::Difference;
use crate::tree::compare::told::About;

pub(super) use self::page::curves;
pub use self::page::page;
pub use self::picture::{Laid, Overlay, Shown, picture};
pub(super) use self::picture::{colour, tubes_along};

/// A row a number: what each tree has, and how much more than the first as a part of that.
pub fn table<'a>(
    about: &[About],
    trees: &'a [Studied],
    to_first: &'a [&[Difference]],
) -> Table<'a> {
    let column = |name: String, kind, meaning: &str| Column {
        name,
        kind,
        unit: "",
        meaning: meaning.to_owned(),
        definition: "whole",
    };
    let mut columns = vec![
        column(
            "number".to_owned(),
            Kind::Text,
            "what is counted or measured",
        ),
        column(
            "unit".to_owned(),
            Kind::Text,
            "what it is told in; length: the tree's own unit",
        ),
    ];
    for one in about {
        columns.push(column(one.name.clone(), Kind::Real, "what this tree has"));
    }
    for one in about.iter().skip(1) {
        let name = format!("{} relative to {}", one.name, about[0].name);
        columns.push(column(
            name,
            Kind::Real,
            "how much more it has, as a part of what the first has",
        ));
    }
    let all = trees.len();
    let cells = move |row: usize, place: usize| match place {
        0 => Cell::Text(trees[0].numbers[row].name),
        1 => Cell::Text(trees[0].numbers[row].unit()),
        place if place < 2 + all => Cell::or_empty(trees[place - 2].numbers[row].value, Cell::Real),
        place => Cell::or_empty(to_first[place - 2 - all][row].relative, Cell::Real),
    };
    Table {
        columns,
        rows: trees.first().map_or(0, |tree| tree.numbers.len()),
        cells: Box::new(cells),
    }
}
