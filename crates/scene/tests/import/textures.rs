//! Textures: images, samplers, transforms, and missing images.

use glam::Vec2;
use serde_json::{Value, json};
use surelight_scene::{Filter, LoadOptions, Scene, Texture, Wrap, load_bytes};

use crate::build::{Gltf, png, warned};

/// The square with a base colour texture that `edit` has changed.
fn textured(info: Value, edit: impl Fn(&mut Gltf)) -> Gltf {
    let mut gltf = Gltf::square();
    gltf.texture();
    edit(&mut gltf);
    gltf.material(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}))
}

fn load(edit: impl Fn(&mut Gltf)) -> Scene {
    textured(json!({"index": 0}), edit).load()
}

fn left_out(scene: &Scene, part: &str) {
    assert_eq!(scene.materials[0].base_color_texture, None);
    assert!(scene.images.is_empty() && scene.textures.is_empty());
    warned(scene, part);
}

#[test]
fn images_are_decoded() {
    let scene = load(|_| {});
    let image = &scene.images[0];
    assert_eq!((image.width, image.height, &image.rgba[..8]), (2, 2, &[255, 0, 0, 255, 0, 255, 0, 255][..]));
    let texture = scene.materials[0].base_color_texture.as_ref().expect("texture");
    assert_eq!((texture.texture, texture.uv_set, texture.transform), (0, 0, None));
    let expected = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Linear };
    assert_eq!(scene.textures, [expected]);
}

#[test]
fn grey_sixteen_bit_and_jpeg_images_become_rgba8() {
    use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
    let wide = DynamicImage::ImageLuma16(ImageBuffer::from_pixel(2, 1, Luma([0x8080_u16])));
    let jpeg = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(8, 8, Rgb([128, 128, 128])));
    for (image, format) in [(wide, ImageFormat::Png), (jpeg, ImageFormat::Jpeg)] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).expect("encodes");
        let scene = load(|gltf| {
            // The MIME type is wrong; the bytes decide.
            let view = gltf.view(bytes.get_ref());
            gltf.json["images"][0] = json!({"bufferView": view, "mimeType": "image/webp"});
        });
        assert_eq!(&scene.images[0].rgba[..4], [128, 128, 128, 255]);
    }
}

#[test]
fn samplers() {
    let scene = load(|gltf| {
        gltf.json["samplers"] = json!([{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}]);
        gltf.json["textures"][0]["sampler"] = json!(0);
    });
    let expected =
        Texture { image: 0, wrap_s: Wrap::ClampToEdge, wrap_t: Wrap::MirroredRepeat, filter: Filter::Nearest };
    assert_eq!(scene.textures, [expected]);
    warned(&load(|gltf| gltf.json["textures"][0]["sampler"] = json!(5)), "sampler 5");
    let scene = load(|gltf| {
        gltf.json["samplers"] = json!([{"wrapS": 1}]);
        gltf.json["textures"][0]["sampler"] = json!(0);
    });
    warned(&scene, "wrap mode 1");
}

#[test]
fn transforms() {
    let apply = |json: Value, uv: [f32; 2]| {
        let info = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": json}});
        let scene = textured(info, |_| {}).load();
        let texture = scene.materials[0].base_color_texture.clone().expect("texture");
        texture.transform.map_or(Vec2::from(uv), |t| t.transform_point2(Vec2::from(uv)))
    };
    let close = |a: Vec2, x: f32, y: f32| assert!((a - Vec2::new(x, y)).length() < 1e-6, "{a}");
    close(apply(json!({}), [0.3, 0.4]), 0.3, 0.4);
    close(apply(json!({"offset": [0.5, -1]}), [0.3, 0.4]), 0.8, -0.6);
    close(apply(json!({"scale": [2, 3]}), [0.3, 0.4]), 0.6, 1.2);
    // "Counter-clockwise" with v downwards: a quarter turn takes u to −v, and v to u.
    let quarter = std::f64::consts::FRAC_PI_2;
    close(apply(json!({"rotation": quarter}), [1.0, 0.0]), 0.0, -1.0);
    close(apply(json!({"rotation": quarter}), [0.0, 1.0]), 1.0, 0.0);
    // First scale, then turn, then move.
    close(apply(json!({"rotation": quarter, "scale": [2, 3], "offset": [10, 20]}), [1.0, 1.0]), 13.0, 18.0);
}

#[test]
fn the_transform_may_choose_another_coordinate_set() {
    let info = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}});
    let scene = textured(info, |_| {}).load();
    assert_eq!(scene.materials[0].base_color_texture.as_ref().map(|t| t.uv_set), Some(1));
    assert_eq!(scene.meshes[0].uvs.len(), 2);
}

#[test]
fn odd_transforms_are_ignored_with_a_word() {
    for json in [json!({"scale": [1e30, 1]}), json!({"offset": [1e300, 0]}), json!({"rotation": "left"}), json!(3)] {
        let info = json!({"index": 0, "extensions": {"KHR_texture_transform": json}});
        let scene = textured(info, |_| {}).load();
        assert_eq!(scene.materials[0].base_color_texture.as_ref().expect("texture").transform, None);
        warned(&scene, "KHR_texture_transform of material 0");
    }
}

#[test]
fn an_image_is_decoded_once_and_only_if_used() {
    let mut gltf = Gltf::square();
    let first = gltf.texture();
    let image = gltf.json["images"][0].clone();
    let copy = gltf.push("images", image);
    let second = gltf.push("textures", json!({"source": copy}));
    gltf.push("images", json!({"uri": "unused and missing.png"}));
    let gltf = gltf.material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": first}}, "emissiveTexture": {"index": second},
    }));
    let scene = gltf.load();
    assert_eq!((scene.images.len(), scene.textures.len()), (1, 1));
    assert!(scene.materials[0].emissive_texture.is_some());
    assert!(scene.warnings.is_empty());
}

#[test]
fn textures_that_cannot_be_had_are_left_out() {
    left_out(&load(|g| g.json["images"][0] = json!({"uri": "gone.png"})), "gone.png");
    left_out(&load(|g| g.json["images"][0] = json!({"uri": "../x.png"})), "leaves");
    left_out(&load(|g| g.json["images"][0] = json!({"uri": "http://x/y.png"})), "only data: and relative");
    left_out(&load(|g| g.json["images"][0] = json!({"uri": "data:image/png;base64,iVBORw0KGgo="})), "decoded");
    left_out(&load(|g| g.json["images"][0] = json!({"uri": "data:image/png;base64,"})), "no bytes");
    left_out(&load(|g| g.json["images"][0] = json!({"uri": "data:,hello"})), "neither PNG, JPEG, WebP nor KTX2");
    left_out(&load(|g| g.json["images"][0] = json!({})), "neither a URI nor a bufferView");
    left_out(&load(|g| g.json["images"][0] = json!({"bufferView": 88})), "bufferView 88");
    left_out(&load(|g| g.json["textures"][0] = json!({"source": 4})), "image 4");
    left_out(&load(|g| g.json["textures"][0] = json!({})), "texture 0 has no source");
    let dds = json!({"extensions": {"MSFT_texture_dds": {"source": 0}}});
    left_out(&load(|g| g.json["textures"][0] = dds.clone()), "MSFT_texture_dds");
    left_out(&textured(json!({"index": 9}), |_| {}).load(), "texture 9");
    left_out(&textured(json!({}), |_| {}).load(), "does not say which");
    left_out(&textured(json!({"index": 0, "texCoord": 1_000_000_000}), |_| {}).load(), "TEXCOORD_1000000000");
}

#[test]
fn every_cut_of_a_png_is_survived() {
    let pixels: Vec<u8> = (0..16 * 16 * 4).map(|i| (i * 37 % 251) as u8).collect();
    let whole = png(16, 16, &pixels);
    for length in 1..whole.len() {
        let scene = load(|gltf| {
            let view = gltf.view(&whole[..length]);
            gltf.json["images"][0] = json!({"bufferView": view});
        });
        // Only the end chunk may be missing without harm.
        assert!(scene.warnings.len() == 1 || length > whole.len() - 12, "{length}");
    }
}

#[test]
fn large_images_are_left_out() {
    let glb = textured(json!({"index": 0}), |_| {}).glb();
    let with = |most| {
        let options = LoadOptions { max_image_pixels: most, ..LoadOptions::default() };
        load_bytes(&glb, "made.glb".as_ref(), &options).expect("loads")
    };
    assert_eq!(with(4).images.len(), 1);
    left_out(&with(3), "2 × 2 pixels, above the limit of 3");
}

#[test]
fn an_image_bomb_is_not_unpacked() {
    // A header that claims 60000 × 60000 pixels, with its checksum.
    let mut bytes = png(1, 1, &[0; 4]);
    let mut header = b"IHDR".to_vec();
    header.extend(60_000_u32.to_be_bytes());
    header.extend(60_000_u32.to_be_bytes());
    header.extend([8, 6, 0, 0, 0]);
    let checksum = header.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 })
    });
    bytes[12..29].copy_from_slice(&header);
    bytes[29..33].copy_from_slice(&(!checksum).to_be_bytes());
    let scene = load(|gltf| {
        let view = gltf.view(&bytes);
        gltf.json["images"][0] = json!({"bufferView": view});
    });
    left_out(&scene, "60000 × 60000 pixels, above the limit");
}

#[test]
fn all_images_together_are_limited() {
    // 17 images of the largest size allowed: one too many.
    let mut gltf = Gltf::square();
    let primitive = gltf.primitive().clone();
    let mut primitives = Vec::new();
    for i in 0..17_u8 {
        let view = gltf.view(&png(2, 2, &[i; 16]));
        let image = gltf.push("images", json!({"bufferView": view}));
        let texture = gltf.push("textures", json!({"source": image}));
        let material = gltf.push("materials", json!({"emissiveTexture": {"index": texture}}));
        let mut primitive = primitive.clone();
        primitive["material"] = json!(material);
        primitives.push(primitive);
    }
    gltf.json["meshes"][0]["primitives"] = json!(primitives);
    let options = LoadOptions { max_image_pixels: 4, ..LoadOptions::default() };
    let scene = load_bytes(&gltf.glb(), "made.glb".as_ref(), &options).expect("loads");
    assert_eq!(scene.images.len(), 16);
    warned(&scene, "more than 64 pixels");
}

/// The pixel of an image of one pixel, written by the image crate in `format` from `image`.
fn one_pixel(image: image::DynamicImage, format: image::ImageFormat, extension: Option<&str>) -> [u8; 4] {
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, format).expect("encodes");
    let scene = load(|gltf| {
        let view = gltf.view(out.get_ref());
        gltf.json["images"][0] = json!({"bufferView": view});
        if let Some(name) = extension {
            gltf.json["textures"][0] = json!({"extensions": {name: {"source": 0}}});
            gltf.json["extensionsUsed"] = json!([name]);
            gltf.json["extensionsRequired"] = json!([name]);
        }
    });
    assert_eq!(scene.warnings, Vec::<String>::new());
    scene.images[0].rgba[..4].try_into().expect("a pixel")
}

#[test]
fn grey_and_16_bit_images_become_8_bit_colours() {
    use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
    let png = |image| one_pixel(image, ImageFormat::Png, None);
    assert_eq!(png(DynamicImage::ImageLuma8(ImageBuffer::from_pixel(1, 1, Luma([90])))), [90, 90, 90, 255]);
    assert_eq!(png(DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(1, 1, LumaA([90, 7])))), [90, 90, 90, 7]);
    // 16 bits are rounded to the nearest of 8: 257 n encodes n.
    let half = 257 * 100 + 128;
    assert_eq!(png(DynamicImage::ImageLuma16(ImageBuffer::from_pixel(1, 1, Luma([half])))), [100, 100, 100, 255]);
    assert_eq!(
        png(DynamicImage::ImageRgb16(ImageBuffer::from_pixel(1, 1, Rgb([half + 1, 0, 65535])))),
        [101, 0, 255, 255]
    );
    let rgba = Rgba([257, 514, 771, 257 * 200]);
    assert_eq!(png(DynamicImage::ImageRgba16(ImageBuffer::from_pixel(1, 1, rgba))), [1, 2, 3, 200]);
}

#[test]
fn webp_textures_load() {
    let pixel = image::ImageBuffer::from_pixel(1, 1, image::Rgba([12, 34, 56, 255]));
    let image = image::DynamicImage::ImageRgba8(pixel);
    // Lossless, so that the pixel is the same.
    assert_eq!(one_pixel(image, image::ImageFormat::WebP, Some("EXT_texture_webp")), [12, 34, 56, 255]);
}

#[test]
fn webp_is_preferred_to_its_fallback() {
    let scene = load(|gltf| {
        let blue = gltf.view(&png(1, 1, &[0, 0, 255, 255]));
        let webp = gltf.push("images", json!({"bufferView": blue}));
        gltf.json["textures"][0]["extensions"] = json!({"EXT_texture_webp": {"source": webp}});
        gltf.json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    });
    // The bytes decide the format of an image.
    assert_eq!(scene.images[0].rgba, [0, 0, 255, 255]);
}

/// The square whose texture has image 1 of these bytes in an extension, beside a sound image 0.
fn beside_a_png(extension: &str, bytes: &[u8]) -> Gltf {
    textured(json!({"index": 0}), |gltf| {
        let view = gltf.view(bytes);
        let image = gltf.push("images", json!({"bufferView": view}));
        gltf.json["textures"][0]["extensions"] = json!({extension: {"source": image}});
        gltf.json["extensionsUsed"] = json!([extension]);
    })
}

#[test]
fn the_fallback_of_a_broken_image_is_used_with_a_warning() {
    let pixel = image::DynamicImage::ImageRgba8(image::ImageBuffer::from_pixel(1, 1, image::Rgba([12, 34, 56, 255])));
    let mut webp = std::io::Cursor::new(Vec::new());
    pixel.write_to(&mut webp, image::ImageFormat::WebP).expect("encodes");
    let webp = webp.into_inner();
    // Only a header, of 1 × 1 pixels in no level.
    let mut ktx2 = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    ktx2.extend([37, 1, 1, 1, 0, 0, 1, 0].into_iter().flat_map(u32::to_le_bytes));
    for (extension, bytes, cause) in [
        // Found when the header is read, and when the pixels are.
        ("EXT_texture_webp", &webp[..20], "image 1 cannot be decoded"),
        ("EXT_texture_webp", &webp[..webp.len() - 2], "image 1 cannot be decoded"),
        ("KHR_texture_basisu", &ktx2, "image 1 is a KTX2 file"),
        ("KHR_texture_basisu", b"no image", "image 1 is neither"),
    ] {
        let scene = beside_a_png(extension, bytes).load();
        assert_eq!(scene.images.len(), 1);
        assert_eq!(scene.images[0].rgba[..4], [255, 0, 0, 255]);
        assert!(scene.materials[0].base_color_texture.is_some());
        warned(&scene, "Image 0 is used as the fallback of image 1: ");
        warned(&scene, cause);
    }
    let mut missing = beside_a_png("KHR_texture_basisu", b"");
    missing.json["images"][1] = json!({"uri": "gone.ktx2"});
    warned(&missing.load(), "gone.ktx2 cannot be read");
    // Nothing is said of a fallback that nothing needs, and all is said where both are broken.
    let mut sound = beside_a_png("EXT_texture_webp", &webp);
    sound.json["images"][0] = json!({"uri": "gone.png"});
    assert_eq!(sound.load().warnings, Vec::<String>::new());
    let mut broken = beside_a_png("EXT_texture_webp", b"no image");
    broken.json["images"][0] = json!({"uri": "gone.png"});
    let scene = broken.load();
    left_out(&scene, "image 1 is neither");
    left_out(&scene, "gone.png cannot be read");
}

#[test]
fn a_fallback_is_decoded_once_for_all_that_share_it() {
    let mut gltf = beside_a_png("EXT_texture_webp", b"no image");
    let copy = gltf.json["images"][0].clone();
    let copy = gltf.push("images", copy);
    let texture = gltf.push("textures", json!({"source": copy}));
    gltf.json["materials"][0]["emissiveTexture"] = json!({"index": texture});
    let scene = gltf.load();
    assert_eq!((scene.images.len(), scene.textures.len()), (1, 1));
    warned(&scene, "fallback of image 1");
}
