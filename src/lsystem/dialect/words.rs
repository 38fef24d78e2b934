//! Symbols of L-Py as they stand in a string: signs, words, and other names for the same.

use std::collections::HashMap;

use super::reader::Reader;
use super::text::Fault;

/// Other names of symbols.
const ALIASES: [(&str, &str); 47] = [
    ("SB", "["),
    ("EB", "]"),
    ("MouseIns", "X"),
    ("Cut", "%"),
    ("any", "*"),
    ("repexp", "x"),
    ("all", "x"),
    ("GetPos", "?P"),
    ("GetHead", "?H"),
    ("GetUp", "?U"),
    ("GetLeft", "?L"),
    ("GetRight", "?R"),
    ("GetFrame", "?F"),
    ("GetIterator", "?I"),
    ("GetModule", "$"),
    ("newmodule", "new"),
    ("StartGC", "@Gc"),
    ("EndGC", "@Ge"),
    ("BP", "{"),
    ("EP", "}"),
    ("PP", "."),
    ("MoveTo", "@M"),
    ("SetHead", "@R"),
    ("Left", "+"),
    ("Right", "-"),
    ("Up", "^"),
    ("Down", "&"),
    ("RollL", "/"),
    ("RollR", "\\"),
    ("TurnAround", "|"),
    ("RollToVert", "@v"),
    ("Sphere", "@O"),
    ("Circle", "@o"),
    ("Box", "@B"),
    ("Quad", "@b"),
    ("Label", "@L"),
    ("IncWidth", "_"),
    ("DecWidth", "!"),
    ("IncColor", ";"),
    ("DecColor", ","),
    ("DivScale", "@Dd"),
    ("MultScale", "@Di"),
    ("SetScale", "@D"),
    ("PglShape", "@g"),
    ("Elasticity", "@Ts"),
    ("Tropism", "@Tp"),
    ("StartScreenProjection", "@2D"),
];

/// Names of more than one character, besides the aliases.
const WORDS: [&str; 54] = [
    "nF",
    "or",
    "new",
    "=]",
    "?P",
    "?H",
    "?U",
    "?L",
    "?R",
    "?F",
    "?I",
    "@Gc",
    "@Ge",
    "@M",
    "@R",
    "@v",
    "@O",
    "@o",
    "@B",
    "@b",
    "@L",
    "@Dd",
    "@Di",
    "@D",
    "@g",
    "@Ts",
    "@Tp",
    "@2D",
    "@3D",
    "MoveRel",
    "LineTo",
    "OLineTo",
    "LineRel",
    "OLineRel",
    "Pinpoint",
    "PinpointRel",
    "EulerAngles",
    "iRollL",
    "iRollR",
    "SetWidth",
    "SetColor",
    "InterpolateColors",
    "surface",
    "Frame",
    "SetContour",
    "SectionResolution",
    "SetGuide",
    "EndGuide",
    "Sweep",
    "PositionOnGuide",
    "TextureScale",
    "LeftReflection",
    "UpReflection",
    "HeadingReflection",
];

/// Names of modules of more than one character.
pub(super) struct Words {
    /// By first character, longest first.
    by_first: HashMap<char, Vec<String>>,
}

impl Words {
    /// Those that L-Py has by itself.
    pub(super) fn new() -> Self {
        let mut words = Self {
            by_first: HashMap::new(),
        };
        let textures = [
            "TextureUScale",
            "TextureVScale",
            "TextureTranslation",
            "TextureRotation",
            "TextureTransformation",
        ];
        for word in WORDS
            .iter()
            .chain(&textures)
            .chain(ALIASES.iter().map(|(name, _)| name))
        {
            words.add(word);
        }
        words
    }

    /// Adds a declared one.
    pub(super) fn add(&mut self, word: &str) {
        let Some(first) = word.chars().next() else {
            return;
        };
        let list = self.by_first.entry(first).or_default();
        if let Err(place) = list.binary_search_by(|known| {
            word.len()
                .cmp(&known.len())
                .then_with(|| known.as_str().cmp(word))
        }) {
            list.insert(place, word.to_owned());
        }
    }

    /// The symbol that stands here, under its first name.
    pub(super) fn symbol(&self, reader: &mut Reader<'_>) -> Result<String, Fault> {
        reader.skip_blank();
        let rest = reader.rest();
        let Some(first) = rest.chars().next() else {
            return Err(reader.expected("a module"));
        };
        let known = self.by_first.get(&first);
        if let Some(word) =
            known.and_then(|list| list.iter().find(|w| rest.starts_with(w.as_str())))
        {
            reader.advance(word.len());
            let alias = ALIASES.iter().find(|(name, _)| name == word);
            return Ok(alias.map_or_else(|| word.clone(), |(_, key)| (*key).to_owned()));
        }
        if matches!(first, '(' | ')') {
            return Err(reader.expected("a module"));
        }
        reader.bump();
        let mut key = first.to_string();
        if first == '~'
            && let Some(shape) = reader.peek().filter(|c| c.is_alphabetic())
        {
            reader.bump();
            key.push(shape);
        }
        Ok(key)
    }
}
