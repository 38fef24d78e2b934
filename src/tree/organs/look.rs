//! How things look: indices of colours and materials as the turtle holds them, and what they mean.
//!
//! Colour 0 is each thing's own (bark for segments and spheres, green for leaves and polygons) unless the grammar gives it one. Colours 1 to 6
//! are those of L-Py's palette in kind (brown, green, red, yellow, blue, purple), so that a grammar brought over looks as it did; the others
//! are what plants need besides. Indices past the palette begin it again.

use std::collections::{BTreeMap, HashMap};

use crate::tree::bark::Bark;

/// Red, green and blue, linear, each 0 to 1.
pub type Colour = [f32; 3];

/// Index of a colour and of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Paint {
    /// Index of the colour; 0 is the thing's own where the grammar gives it none.
    pub colour: u16,
    /// Index of the material.
    pub material: u16,
}

/// How light leaves a surface, as glTF's metallic-roughness model says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// 0 (a mirror) to 1 (matte).
    pub roughness: f32,
    /// 0 (a plant) to 1 (metal).
    pub metallic: f32,
}

/// The materials that are there without a grammar's word: matte, a glossy leaf, a wet fruit, metal. Others are matte.
const MATERIALS: [[f32; 2]; 4] = [[0.9, 0.0], [0.45, 0.0], [0.2, 0.0], [0.35, 1.0]];

/// Colours 1 to 15, sRGB: brown, green, red, yellow, blue, purple, white, pink, orange, light green, dark green, olive,
/// straw, lilac, black.
const COLOURS: [[u8; 3]; 15] = [
    [121, 85, 52],
    [74, 138, 45],
    [190, 38, 30],
    [235, 196, 40],
    [62, 92, 190],
    [128, 62, 158],
    [244, 243, 236],
    [238, 150, 178],
    [232, 126, 38],
    [142, 190, 74],
    [36, 84, 40],
    [118, 122, 44],
    [212, 186, 128],
    [176, 150, 214],
    [40, 36, 34],
];

/// The own colour of painted wood and of spheres: bark, sRGB.
pub(super) const BROWN: [u8; 3] = [112, 82, 56];

/// sRGB to linear light, 0 to 1.
#[must_use]
pub fn linear(srgb: f32) -> f32 {
    if srgb <= 0.04045 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// Linear light to sRGB, 0 to 1.
#[must_use]
pub fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// A colour given in bytes of sRGB.
#[must_use]
pub fn from_bytes(bytes: [u8; 3]) -> Colour {
    bytes.map(|byte| linear(f32::from(byte) / 255.0))
}

/// The colour of bark where it has no texture.
#[must_use]
pub fn bark_colour() -> Colour {
    from_bytes(BROWN)
}

/// What the indices mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Palette {
    colours: BTreeMap<u16, Colour>,
    materials: BTreeMap<u16, Material>,
    names: BTreeMap<u16, String>,
}

impl Palette {
    /// Gives a colour (sRGB, each 0 to 1) to an index; false where it has one.
    pub fn set_colour(&mut self, index: u16, colour: [f32; 3]) -> bool {
        let value = colour.map(|part| linear(part.clamp(0.0, 1.0)));
        self.colours.insert(index, value).is_none()
    }

    /// Gives a colour (linear) to an index.
    pub fn set_linear(&mut self, index: u16, colour: Colour) {
        self.colours
            .insert(index, colour.map(|part| part.clamp(0.0, 1.0)));
    }

    /// Names a material, for files that have names for them.
    pub fn set_name(&mut self, index: u16, name: &str) {
        self.names.insert(index, name.to_owned());
    }

    /// Whether a material was given a name.
    #[must_use]
    pub fn is_named(&self, index: u16) -> bool {
        self.names.contains_key(&index)
    }

    /// The name of a material.
    #[must_use]
    pub fn name(&self, index: u16) -> String {
        self.names
            .get(&index)
            .cloned()
            .unwrap_or_else(|| format!("material {index}"))
    }

    /// Gives a material to an index; false where it has one.
    pub fn set_material(&mut self, index: u16, material: Material) -> bool {
        self.materials.insert(index, material).is_none()
    }

    /// The colour of an index; `None` where it is the thing's own.
    #[must_use]
    pub fn colour(&self, index: u16) -> Option<Colour> {
        if let Some(colour) = self.colours.get(&index) {
            return Some(*colour);
        }
        let at = usize::from(index).checked_sub(1)? % COLOURS.len();
        COLOURS.get(at).copied().map(from_bytes)
    }

    /// The material of an index.
    #[must_use]
    pub fn material(&self, index: u16) -> Material {
        let known = || {
            let [roughness, metallic] = MATERIALS
                .get(usize::from(index))
                .copied()
                .unwrap_or(MATERIALS[0]);
            Material {
                roughness,
                metallic,
            }
        };
        self.materials.get(&index).copied().unwrap_or_else(known)
    }

    /// Whether a segment with this paint is plain bark.
    #[must_use]
    pub fn is_bark(&self, paint: Paint) -> bool {
        paint.material == 0 && self.colour(paint.colour).is_none()
    }
}

/// Every look that is used, once: what a picture's shader looks up. Number 0 is bark.
#[derive(Clone, Debug)]
pub struct LookTable {
    /// Red, green, blue (linear), roughness; metallic, 0, 0, 0.
    rows: Vec<[f32; 8]>,
    /// By number: the index of the material.
    materials: Vec<u16>,
    number_of: HashMap<([u32; 3], u16), u32>,
}

impl Default for LookTable {
    fn default() -> Self {
        Self::of(Bark::default())
    }
}

impl LookTable {
    /// With the bark that a tree has: the colour of young twigs, how deep furrows are; roughness in furrows and on ridges.
    #[must_use]
    pub fn of(bark: Bark) -> Self {
        let params = bark.params();
        let [r, g, b] = params.young.map(|part| linear(part / 255.0));
        let [low, high] = params.roughness;
        Self {
            rows: vec![[r, g, b, params.relief, low, high, 0.0, 0.0]],
            materials: vec![0],
            number_of: HashMap::new(),
        }
    }
}

impl LookTable {
    /// The rows, as the shader reads them.
    #[must_use]
    pub fn rows(&self) -> &[[f32; 8]] {
        &self.rows
    }

    /// The colour of a number, and the index of its material.
    #[must_use]
    pub fn look(&self, number: u32) -> (Colour, u16) {
        let at = number as usize;
        let row = self.rows.get(at).copied().unwrap_or_default();
        let material = self.materials.get(at).copied().unwrap_or(0);
        ([row[0], row[1], row[2]], material)
    }

    /// The number of a painted segment's look: 16 bits. A drawing with more looks than that has bark for the rest.
    pub fn segment(&mut self, palette: &Palette, paint: Paint) -> u32 {
        let bark = from_bytes(BROWN);
        let colour = palette.colour(paint.colour).unwrap_or(bark);
        let number = self.number(colour, palette, paint.material);
        if number > u32::from(u16::MAX) {
            0
        } else {
            number
        }
    }

    /// The number of a colour in a material.
    pub fn number(&mut self, colour: Colour, palette: &Palette, index: u16) -> u32 {
        let material = palette.material(index);
        let key = (colour.map(f32::to_bits), index);
        let (rows, materials) = (&mut self.rows, &mut self.materials);
        *self.number_of.entry(key).or_insert_with(|| {
            let [r, g, b] = colour;
            let Material {
                roughness,
                metallic,
            } = material;
            materials.push(index);
            rows.push([r, g, b, roughness, metallic, 0.0, 0.0, 0.0]);
            u32::try_from(rows.len() - 1).unwrap_or(0)
        })
    }
}
