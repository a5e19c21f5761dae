use glam::Affine2;

/// A decoded image: 8-bit RGBA, row 0 at the top, not yet linearised.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Where it came from: a URI or "image 3".
    pub name: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height * 4` bytes.
    pub rgba: Vec<u8>,
}

/// An image and how it is looked up.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Texture {
    /// Index into [`crate::Scene::images`].
    pub image: usize,
    /// Along u.
    pub wrap_s: Wrap,
    /// Along v.
    pub wrap_t: Wrap,
    /// Between texels. Minification filters are not needed: samples average.
    pub filter: Filter,
}

/// Addressing outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The image mirrored.
    MirroredRepeat,
    /// Its edge.
    ClampToEdge,
}

/// How texels are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// Bilinear.
    Linear,
    /// The nearest texel.
    Nearest,
}

/// A texture as a material uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`crate::Scene::textures`].
    pub texture: usize,
    /// Which UV set: index into [`crate::Mesh::uvs`].
    pub uv_set: u32,
    /// KHR_texture_transform, when it is not the identity.
    pub transform: Option<Affine2>,
}

/// A normal map and its strength.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalTexture {
    /// The map, linear.
    pub texture: TextureRef,
    /// Factor on x and y before normalisation.
    pub scale: f32,
}
