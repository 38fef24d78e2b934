//! Statements about looks: `colour 3 = 0.2 0.6 0.1`, `material 1 = roughness 0.4`, `surface L = leaf`.

use std::collections::BTreeMap;

use glam::Vec3;

use super::error::{GrammarError, nearest};
use super::expression::signed;
use super::names::{Names, Symbol};
use super::source::Cursor;
use crate::tree::organs::{BUILT_IN, MOST_CORNERS, Material, Palette, Surface};

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
