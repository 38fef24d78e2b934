//! Statements about looks: `colour 3 = 0.2 0.6 0.1`, `material 1 = roughness 0.4`, `surface L = leaf`, `bark oak`, `bears maple size 0.12`,
//! `season autumn`, `widths da-vinci tip 0.003`.

use std::collections::BTreeMap;

use glam::Vec3;

use super::error::{GrammarError, nearest};
use super::expression::signed;
use super::names::{Names, Symbol};
use super::source::{Cursor, Source};
use crate::tree::bark::Bark;
use crate::tree::foliage::{Bearing, Dress, NUMBERS, Ranks, Season, USUAL_FLARE, kinds};
use crate::tree::organs::{BUILT_IN, MOST_CORNERS, Material, Palette, Surface};
use crate::tree::radii::RadiusParams;

/// A dictionary entry that `~` places.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedSurface {
    pub(crate) name: String,
    pub(crate) surface: Surface,
}

/// For each symbol `~L` the surface that it places; where `L` is neither a surface nor a shape, a leaf is added for all such.
pub(crate) fn surfaces_by_symbol(
    names: &Names,
    surfaces: &mut Vec<NamedSurface>,
    is_shape: impl Fn(&str) -> bool,
) -> Vec<Option<u16>> {
    let given: BTreeMap<String, usize> = surfaces
        .iter()
        .enumerate()
        .map(|(at, named)| (named.name.clone(), at))
        .collect();
    let mut leaf = None;
    let symbols = 0..Symbol::try_from(names.symbols().len()).unwrap_or(Symbol::MAX);
    symbols
        .map(|symbol| {
            let name = names.name(symbol).strip_prefix('~')?;
            if is_shape(name) {
                return None;
            }
            let at = *given.get(name).unwrap_or_else(|| {
                leaf.get_or_insert_with(|| {
                    surfaces.push(NamedSurface {
                        name: "leaf".to_owned(),
                        surface: Surface::built_in("leaf").unwrap_or_default(),
                    });
                    surfaces.len() - 1
                })
            });
            u16::try_from(at).ok()
        })
        .collect()
}

/// The whole number of a colour or material, and the byte at which it stands.
fn index(cursor: &mut Cursor<'_>) -> Result<(u16, usize), GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let digits = cursor.rest().bytes().take_while(u8::is_ascii_digit).count();
    let found = cursor.rest().get(..digits).and_then(|t| t.parse().ok());
    let index = found.ok_or_else(|| cursor.expected("a whole number from 0 to 65535"))?;
    cursor.advance(digits);
    Ok((index, at))
}

/// A number from 0 to 1.
fn part(cursor: &mut Cursor<'_>, what: &str) -> Result<f32, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let value = signed(cursor)?;
    if !(0.0..=1.0).contains(&value) {
        return Err(cursor.error_at(
            at,
            format!("found `{value}`; expected {what} as a number from 0 to 1"),
        ));
    }
    #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
    Ok(value as f32)
}

/// Reads `3 = 0.2 0.6 0.1`.
pub(crate) fn colour(palette: &mut Palette, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
    let (index, at) = index(cursor)?;
    cursor.expect("=")?;
    let mut parts = [0.0; 3];
    for (value, what) in parts.iter_mut().zip(["red", "green", "blue"]) {
        *value = part(cursor, what)?;
        cursor.take(",");
    }
    if !palette.set_colour(index, parts) {
        return Err(cursor.error_at(at, format!("the colour {index} is given twice")));
    }
    Ok(())
}

/// Reads `1 = roughness 0.4 metallic 0`, both of which may be left out.
pub(crate) fn material(palette: &mut Palette, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
    let (index, at) = index(cursor)?;
    cursor.expect("=")?;
    let mut material = Material {
        roughness: 0.9,
        metallic: 0.0,
    };
    let expected = "`roughness` or `metallic`, each with a number from 0 to 1";
    if cursor.at_end() {
        return Err(cursor.expected(expected));
    }
    while !cursor.at_end() {
        match cursor.identifier() {
            Some("roughness") => material.roughness = part(cursor, "roughness")?,
            Some("metallic") => material.metallic = part(cursor, "metallic")?,
            _ => return Err(cursor.expected(expected)),
        }
        cursor.take(",");
    }
    if !palette.set_material(index, material) {
        return Err(cursor.error_at(at, format!("the material {index} is given twice")));
    }
    Ok(())
}

/// Reads `L = leaf` or `L = [(x y z) …]`.
pub(crate) fn surface(
    names: &Names,
    cursor: &mut Cursor<'_>,
) -> Result<NamedSurface, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let name = names.read(cursor)?;
    if !name.chars().next().is_some_and(char::is_alphanumeric) {
        return Err(cursor.error_at(
            at,
            format!("`{name}` is a sign of the turtle; expected a letter"),
        ));
    }
    cursor.expect("=")?;
    let surface = if cursor.take("[") {
        outline(cursor, at)?
    } else {
        built_in(cursor)?
    };
    Ok(NamedSurface {
        name: name.to_owned(),
        surface,
    })
}

fn built_in(cursor: &mut Cursor<'_>) -> Result<Surface, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let listed = format!(
        "one of {}, or an outline `[(x y z) …]`",
        BUILT_IN.join(", ")
    );
    let Some(word) = cursor.identifier() else {
        return Err(cursor.expected(&listed));
    };
    Surface::built_in(word).ok_or_else(|| {
        let word: String = word.chars().take(40).collect();
        let hint = nearest(&word, BUILT_IN.iter().copied()).map_or(String::new(), |n| {
            format!("; the nearest known one is `{n}`")
        });
        cursor.error_at(at, format!("found `{word}`; expected {listed}{hint}"))
    })
}

/// The corners of an outline, after its `[`.
fn outline(cursor: &mut Cursor<'_>, at: usize) -> Result<Surface, GrammarError> {
    let mut corners = Vec::new();
    while !cursor.take("]") {
        cursor.expect("(")?;
        let mut corner = [0.0; 3];
        for value in &mut corner {
            cursor.skip_blank();
            let at = cursor.pos();
            let given = signed(cursor)?;
            #[expect(clippy::cast_possible_truncation, reason = "what is beyond is refused")]
            let narrow = given as f32;
            if !(-1e6..=1e6).contains(&narrow) {
                return Err(cursor.error_at(
                    at,
                    "a surface is about 1 long; expected numbers from -1000000 to 1000000".into(),
                ));
            }
            *value = narrow;
            cursor.take(",");
        }
        if !cursor.take(")") {
            return Err(cursor.expected("`)` after x, y and z"));
        }
        cursor.take(",");
        corners.push(Vec3::from(corner));
        if corners.len() > MOST_CORNERS {
            return Err(cursor.expected(&format!(
                "`]`, since an outline has at most {MOST_CORNERS} corners"
            )));
        }
    }
    Surface::outline(&corners).ok_or_else(|| {
        cursor.error_at(
            at,
            "this outline spans no area; expected at least three corners `(x y z)` that do not lie on a line".into(),
        )
    })
}

/// Kinds of leaves, blossoms and fruit beyond which no grammar goes.
const MOST_BEARINGS: usize = 16;

/// One of some words, with what it means.
fn one_of<T>(
    cursor: &mut Cursor<'_>,
    words: impl IntoIterator<Item = (&'static str, T)>,
) -> Result<T, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let word = cursor.identifier().unwrap_or_default();
    let mut known = Vec::new();
    for (name, value) in words {
        if name == word {
            return Ok(value);
        }
        known.push(name);
    }
    let listed = known.join(", ");
    if word.is_empty() {
        return Err(cursor.expected(&format!("one of {listed}")));
    }
    let word: String = word.chars().take(40).collect();
    let hint = nearest(&word, known.iter().copied()).map_or(String::new(), |n| {
        format!("; the nearest known one is `{n}`")
    });
    Err(cursor.error_at(
        at,
        format!("found `{word}`; expected one of {listed}{hint}"),
    ))
}

/// Reads `oak flare 0.5`, after `bark`.
pub(crate) fn bark(dress: &mut Dress, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
    dress.bark = one_of(cursor, Bark::ALL.map(|bark| (bark.name(), bark)))?;
    dress.flare = USUAL_FLARE;
    if !cursor.at_end() {
        one_of(cursor, [("flare", ())])?;
        dress.flare = number_within(cursor, "flare", [0.0, 4.0])?;
    }
    Ok(())
}

/// Reads `autumn`, after `season`.
pub(crate) fn season(cursor: &mut Cursor<'_>) -> Result<Season, GrammarError> {
    one_of(cursor, Season::ALL.map(|season| (season.name(), season)))
}

/// Reads `maple size 0.12 every 0.05 in spring summer`, after `bears`; a letter of the grammar's surfaces may stand for the kind.
pub(crate) fn bears(
    dress: &mut Dress,
    surfaces: &[NamedSurface],
    cursor: &mut Cursor<'_>,
) -> Result<(), GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    if dress.bears.len() >= MOST_BEARINGS {
        let message =
            format!("a tree bears at most {MOST_BEARINGS} kinds of leaves, blossoms and fruit");
        return Err(cursor.error_at(at, message));
    }
    let word = cursor.clone().identifier().unwrap_or_default();
    let own = surfaces.iter().find(|named| named.name == word);
    let mut bearing = if let Some(named) = own {
        cursor.identifier();
        Bearing::of_surface(&named.name, &named.surface)
    } else {
        Bearing::of(one_of(cursor, kinds().map(|kind| (kind.name, kind)))?)
    };
    while !cursor.at_end() {
        option(&mut bearing, cursor)?;
    }
    dress.bears.push(bearing);
    Ok(())
}

/// Reads what stands behind `bears`, on its own.
///
/// # Errors
/// What is wrong with it and where.
pub fn bearing(text: &str) -> Result<Bearing, GrammarError> {
    let source = Source::new("bears".to_owned(), text.to_owned());
    let mut dress = Dress::default();
    bears(&mut dress, &[], &mut Cursor::new(&source, 0, text.len()))?;
    dress
        .bears
        .pop()
        .ok_or_else(|| Cursor::new(&source, 0, text.len()).expected("a kind of leaf"))
}

/// Reads one option of a bearing.
fn option(bearing: &mut Bearing, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
    const WORDS: [&str; 4] = ["ranked", "spiral", "tips", "in"];
    let names = NUMBERS.iter().map(|(name, _)| *name).chain(WORDS);
    let name = one_of(cursor, names.map(|name| (name, name)))?;
    match name {
        "ranked" => bearing.ranks = Ranks::Two,
        "spiral" => bearing.ranks = Ranks::Spiral,
        "tips" => bearing.tips = true,
        "in" => {
            bearing.seasons = [false; 4];
            loop {
                let season = season(cursor)?;
                for (one, there) in Season::ALL.iter().zip(&mut bearing.seasons) {
                    *there |= *one == season;
                }
                let next = cursor.clone().identifier().unwrap_or_default();
                if !Season::ALL.iter().any(|one| one.name() == next) {
                    return Ok(());
                }
            }
        }
        name => {
            let bounds = NUMBERS.iter().find(|(known, _)| *known == name);
            let [least, most] = bounds.map_or([0.0; 2], |(_, bounds)| *bounds);
            bearing.set(name, number_within(cursor, name, [least, most])?);
        }
    }
    Ok(())
}

/// A number within bounds.
fn number_within(
    cursor: &mut Cursor<'_>,
    what: &str,
    [least, most]: [f32; 2],
) -> Result<f32, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    let value = signed(cursor)?;
    #[expect(clippy::cast_possible_truncation, reason = "what is beyond is refused")]
    let narrow = value as f32;
    if (least..=most).contains(&narrow) {
        return Ok(narrow);
    }
    Err(cursor.error_at(
        at,
        format!("found `{value}`; expected {what} as a number from {least} to {most}"),
    ))
}

/// What the turtle's widths are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Widths {
    /// Metres, unless they are far too large for that.
    #[default]
    Auto,
    /// Metres.
    Metres,
    /// Nothing: radii follow da Vinci's rule.
    DaVinci(RadiusParams),
}

/// Reads `metres`, or `da-vinci tip 0.004 exponent 2`, after `widths`.
pub(crate) fn widths(cursor: &mut Cursor<'_>) -> Result<Widths, GrammarError> {
    cursor.skip_blank();
    if cursor.take("metres") {
        return Ok(Widths::Metres);
    }
    if !cursor.take("da-vinci") {
        return Err(cursor.expected("`metres` or `da-vinci`"));
    }
    let mut params = RadiusParams::default();
    while !cursor.at_end() {
        match one_of(cursor, [("tip", true), ("exponent", false)])? {
            true => params.tip_radius = number_within(cursor, "tip", RadiusParams::TIP_RADIUS)?,
            false => params.exponent = number_within(cursor, "exponent", RadiusParams::EXPONENT)?,
        }
    }
    Ok(Widths::DaVinci(params))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn what_a_bearing_says_is_read_again() {
        for kind in kinds() {
            let mut wild = Bearing::of(kind);
            for (number, (name, [least, most])) in (1_u8..).zip(NUMBERS) {
                wild.set(
                    name,
                    least + (most.min(20.0) - least) * f32::from(number) / 16.0,
                );
            }
            (wild.tips, wild.seasons) = (true, [false, true, false, true]);
            wild.ranks = match wild.ranks {
                Ranks::Two => Ranks::Spiral,
                Ranks::Spiral => Ranks::Two,
            };
            for bearing in [Bearing::of(kind), wild] {
                let said = bearing.to_string();
                assert_eq!(super::bearing(&said).unwrap(), bearing, "{said}");
            }
        }
    }
}
