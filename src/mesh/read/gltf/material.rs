//! Materials (§3.9): those that some triangle has, and their images.

use std::collections::BTreeMap;

use ::gltf::json::Root;
use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::material::{AlphaMode, Material as Json, NormalTexture};
use ::gltf::json::texture::{Info, Sampler, WrappingMode};
use ::gltf::json::validation::Checked;
use glam::{Affine2, Vec2, Vec3, Vec4};

use super::super::{Stop, with_room};
use super::elements::Accessors;
use super::images::Images;
use super::surface::Source;
use super::{Remarks, colours, shown};
use crate::mesh::paint::{Alpha, Material, Paint, Texture, Wrap};

/// Materials that have numbers of 16 bits.
const MATERIALS_MOST: usize = 1 << 16;
/// White paper in the sun is about 1.
const MOST_LIGHT: f32 = 16.0;

/// An image that a material names.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Use {
    texture: usize,
    /// Which of the texture coordinates it is put on with.
    set: u32,
    image_from_texture: Affine2,
}

impl Use {
    fn of(info: &Info) -> Self {
        let extensions = info.extensions.as_ref();
        let transform = extensions.and_then(|all| all.texture_transform.as_ref());
        Self {
            texture: info.index.value(),
            set: transform
                .and_then(|transform| transform.tex_coord)
                .unwrap_or(info.tex_coord),
            image_from_texture: transform.map_or(Affine2::IDENTITY, affine),
        }
    }

    /// One of normals. The crate leaves its transform as it stands in the file.
    fn of_normals(normals: &NormalTexture) -> Self {
        let extensions = normals.extensions.as_ref();
        let value = extensions.and_then(|all| all.others.get("KHR_texture_transform"));
        let transform =
            value.and_then(|value| serde_json::from_value::<TextureTransform>(value.clone()).ok());
        Self {
            texture: normals.index.value(),
            set: transform
                .as_ref()
                .and_then(|transform| transform.tex_coord)
                .unwrap_or(normals.tex_coord),
            image_from_texture: transform.as_ref().map_or(Affine2::IDENTITY, affine),
        }
    }

    /// Base colour (as either of the models of materials has it), emission, metal and roughness, normals.
    fn all(json: &Json) -> [Option<Self>; 4] {
        let metallic = &json.pbr_metallic_roughness;
        let extensions = json.extensions.as_ref();
        let specular = extensions.and_then(|all| all.pbr_specular_glossiness.as_ref());
        let base = metallic.base_color_texture.as_ref();
        let base = base.or_else(|| specular?.diffuse_texture.as_ref());
        let matter = metallic.metallic_roughness_texture.as_ref();
        [
            base.map(Self::of),
            json.emissive_texture.as_ref().map(Self::of),
            matter.filter(|_| specular.is_none()).map(Self::of),
            json.normal_texture.as_ref().map(Self::of_normals),
        ]
    }
}

/// Which of the texture coordinates a material's images are put on with.
pub(super) fn texture_set(root: &Root, material: Option<usize>) -> u32 {
    let material = material.and_then(|number| root.materials.get(number));
    let first = material.and_then(|json| Use::all(json).into_iter().flatten().next());
    first.map_or(0, |first| first.set)
}

/// All that colours the surface; None where nothing does.
pub(super) fn paint(
    root: &Root,
    source: &Source<'_>,
    accessors: &Accessors<'_>,
    mut images: Images<'_>,
    remarks: &mut Remarks,
) -> Result<Option<Paint>, Stop> {
    let parts = source.shapes().flat_map(|shape| &shape.parts);
    let known = |material: Option<usize>| material.filter(|&at| at < root.materials.len());
    let mut used: BTreeMap<Option<usize>, u16> = BTreeMap::new();
    for part in parts {
        if part.material.is_some() && known(part.material).is_none() {
            remarks.add("a material is not in the file, and the plain one is shown");
        }
        used.entry(known(part.material)).or_default();
    }
    // Numbers in the file's order; without a material comes first.
    if used.len() > MATERIALS_MOST {
        remarks.add(format!(
            "of more than {MATERIALS_MOST} materials the last ones are shown as the first"
        ));
    }
    for (number, to) in used.values_mut().enumerate() {
        *to = u16::try_from(number).unwrap_or(0);
    }
    let mut paint = Paint {
        texture_coordinates: colours::texture_coordinates(source, accessors, remarks)?,
        colours: colours::colours(source, accessors, remarks)?,
        ..Paint::default()
    };
    if used.keys().any(Option::is_some) {
        for number in used.keys().take(MATERIALS_MOST) {
            source.task.go_on()?;
            let json = number.and_then(|number| root.materials.get(number));
            let material = json.map(|json| material(root, json, &mut images, remarks));
            paint
                .materials
                .push(material.transpose()?.unwrap_or_default());
        }
        paint.images = images.images;
    }
    if used.len() > 1 {
        paint.triangle_materials = with_room(source.size.triangles)?;
        source.each(|ready, _| {
            for part in &ready.shape.parts {
                let number = used.get(&known(part.material)).copied().unwrap_or_default();
                let all = &mut paint.triangle_materials;
                all.resize(all.len() + part.triangles, number);
            }
            Ok(())
        })?;
    }
    let is_nothing = paint.materials.is_empty()
        && paint.colours.is_empty()
        && paint.texture_coordinates.is_empty();
    Ok((!is_nothing).then_some(paint))
}

fn material(
    root: &Root,
    json: &Json,
    images: &mut Images<'_>,
    remarks: &mut Remarks,
) -> Result<Material, Stop> {
    let metallic = &json.pbr_metallic_roughness;
    let extensions = json.extensions.as_ref();
    let specular = extensions.and_then(|all| all.pbr_specular_glossiness.as_ref());
    let [
        base_colour_image,
        emission_image,
        metal_roughness_image,
        normal_image,
    ] = textures(root, json, images, remarks)?;
    let part = |value: f32| {
        if value.is_finite() {
            value.clamp(0.0, 1.0)
        } else {
            1.0
        }
    };
    let colour = match specular {
        Some(specular) => specular.diffuse_factor.0,
        None => metallic.base_color_factor.0,
    };
    Ok(Material {
        name: json.name.as_deref().map(shown).unwrap_or_default(),
        base_colour: Vec4::from_array(colour.map(part)),
        base_colour_image,
        emission: emission(json),
        emission_image,
        metal_roughness_image,
        normal_image,
        normal_scale: json
            .normal_texture
            .as_ref()
            .map(|normals| normals.scale)
            .filter(|scale| scale.is_finite())
            .unwrap_or(1.0),
        metallic: match specular {
            Some(_) => 0.0,
            None => part(metallic.metallic_factor.0),
        },
        roughness: match specular {
            Some(specular) => 1.0 - part(specular.glossiness_factor.0),
            None => part(metallic.roughness_factor.0),
        },
        alpha: match json.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => {
                Alpha::Mask(part(json.alpha_cutoff.unwrap_or_default().0))
            }
            Checked::Valid(AlphaMode::Blend) => Alpha::Blend,
            _ => Alpha::Opaque,
        },
        is_double_sided: json.double_sided,
        is_unlit: extensions.is_some_and(|all| all.unlit.is_some()),
    })
}

/// What a surface shines by itself: no more than a lamp that is looked at.
fn emission(json: &Json) -> Vec3 {
    let strength = json.extensions.as_ref().and_then(|all| {
        let strength = all.emissive_strength.as_ref()?;
        Some(strength.emissive_strength.0)
    });
    let light = json.emissive_factor.0.map(|part| {
        let light = part * strength.unwrap_or(1.0);
        // Numbers that are none are no light.
        if light.is_nan() {
            0.0
        } else {
            light.clamp(0.0, MOST_LIGHT)
        }
    });
    Vec3::from_array(light)
}

/// The images of a material. All lie as the first does; what lies otherwise is left out.
fn textures(
    root: &Root,
    json: &Json,
    images: &mut Images<'_>,
    remarks: &mut Remarks,
) -> Result<[Option<Texture>; 4], Stop> {
    let mut found: [Option<Texture>; 4] = [None; 4];
    let mut first: Option<(u32, Texture)> = None;
    for (place, wanted) in found.iter_mut().zip(Use::all(json)) {
        let Some(wanted) = wanted else { continue };
        let Some(texture) = texture(root, &wanted, images, remarks)? else {
            continue;
        };
        let (set, like) = first.get_or_insert((wanted.set, texture));
        let lies = |texture: &Texture| (texture.image_from_texture, texture.wrap);
        if (*set, lies(like)) == (wanted.set, lies(&texture)) {
            *place = Some(texture);
        } else {
            remarks.add(
                "an image that does not lie on its surface as the base colour's does is not shown",
            );
        }
    }
    Ok(found)
}

fn texture(
    root: &Root,
    wanted: &Use,
    images: &mut Images<'_>,
    remarks: &mut Remarks,
) -> Result<Option<Texture>, Stop> {
    let number = wanted.texture;
    let Some(texture) = root.textures.get(number) else {
        remarks.add(format!("texture {number} is not there"));
        return Ok(None);
    };
    if texture.source.value() >= root.images.len() {
        remarks.add(format!(
            "texture {number} has no image as PNG or JPEG and is not shown"
        ));
        return Ok(None);
    }
    let Some(image) = images.number(texture.source.value(), remarks)? else {
        return Ok(None);
    };
    let sampler = texture.sampler.and_then(|at| root.samplers.get(at.value()));
    Ok(Some(Texture {
        image,
        image_from_texture: wanted.image_from_texture,
        wrap: sampler.map_or([Wrap::Repeat; 2], wrap),
    }))
}

/// As `KHR_texture_transform` has it: scaled, then turned counter-clockwise as it is seen with v downwards, then moved.
fn affine(transform: &TextureTransform) -> Affine2 {
    let (sin, cos) = transform.rotation.0.sin_cos();
    let [width, height] = transform.scale.0;
    let affine = Affine2::from_cols(
        Vec2::new(cos * width, -sin * width),
        Vec2::new(sin * height, cos * height),
        Vec2::from_array(transform.offset.0),
    );
    if affine.is_finite() {
        affine
    } else {
        Affine2::IDENTITY
    }
}

fn wrap(sampler: &Sampler) -> [Wrap; 2] {
    [sampler.wrap_s, sampler.wrap_t].map(|mode| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    })
}
