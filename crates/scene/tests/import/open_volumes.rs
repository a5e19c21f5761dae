//! Meshes with a volume: closed ones keep it, open ones become thin-walled and are named.

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use surelight_scene::{Mesh, Scene};
use surelight_scenes::shapes::Shape;

use crate::build::{FLOAT, Gltf, UINT, floats, warned, words};

fn mesh(shape: Shape) -> Mesh {
    shape.bare().into_mesh("", 0, false)
}

fn cube() -> Mesh {
    mesh(Shape::cuboid(DVec3::ZERO, DVec3::ONE))
}

fn sheet() -> Mesh {
    mesh(Shape::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y))
}

/// The triangles of a mesh whose middle is as wanted.
fn cut(mut mesh: Mesh, keep: impl Fn(Vec3) -> bool) -> Mesh {
    let at = |v: u32| mesh.positions[v as usize];
    mesh.triangles.retain(|&[a, b, c]| keep((at(a) + at(b) + at(c)) / 3.0));
    mesh
}

fn turned_over(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh
}

fn moved(mut mesh: Mesh, by: Vec3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

/// Clear glass with a volume as material 0, and a glTF mesh called "pane" of one primitive for each
/// of `meshes`.
fn glass(meshes: &[Mesh]) -> Gltf {
    let mut gltf = Gltf::empty();
    gltf.push(
        "materials",
        json!({
            "name": "glass", "doubleSided": true, "pbrMetallicRoughness": {"roughnessFactor": 0.25},
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2},
            },
        }),
    );
    let primitives: Vec<Value> = meshes.iter().map(|mesh| primitive(&mut gltf, mesh)).collect();
    let mesh = gltf.push("meshes", json!({"name": "pane", "primitives": primitives}));
    let node = gltf.push("nodes", json!({"mesh": mesh}));
    gltf.json["scenes"][0]["nodes"] = json!([node]);
    gltf
}

fn primitive(gltf: &mut Gltf, mesh: &Mesh) -> Value {
    let positions: Vec<f32> = mesh.positions.iter().flat_map(|p| p.to_array()).collect();
    let positions = gltf.accessor(&floats(&positions), FLOAT, "VEC3", mesh.positions.len());
    let indices = gltf.accessor(&words(mesh.triangles.as_flattened()), UINT, "SCALAR", 3 * mesh.triangles.len());
    json!({"attributes": {"POSITION": positions}, "indices": indices, "material": 0})
}

/// All keeps its volume, and there is nothing to say.
#[track_caller]
fn assert_closed(gltf: &Gltf) {
    let scene = gltf.load();
    assert_eq!(scene.warnings, Vec::<String>::new());
    assert!(scene.materials.len() == 1 && scene.materials[0].volume.is_some());
}

/// All becomes thin-walled, with a warning that says how many parts are open.
#[track_caller]
fn assert_open(gltf: &Gltf, parts: &str) {
    let scene = gltf.load();
    warned(&scene, &format!("Mesh 0 (\"pane\") has a volume (KHR_materials_volume), but is not closed in {parts}"));
    assert!(scene.materials.len() == 1 && scene.materials[0].volume.is_none());
}

#[test]
fn open_meshes_become_thin_walled() {
    let open = |mesh: Mesh| assert_open(&glass(&[mesh]), "1 of 1 part,");
    open(sheet());
    open(cut(mesh(Shape::icosphere(3)), |p| p.z > 0.0));
    open(cut(cube(), |p| p.y < 0.9));
    // The area vectors of a tube's two openings cancel.
    open(cut(cube(), |p| p.y < 0.9 && p.y > 0.1));
    // A sheet that is there twice, front and back, closes around nothing.
    let twice = Mesh { triangles: [sheet().triangles, turned_over(sheet()).triangles].concat(), ..sheet() };
    open(twice);
}

#[test]
fn each_part_is_open_by_itself() {
    // Together, windows of the left and the right side would cancel.
    let sides = [sheet(), moved(turned_over(sheet()), Vec3::Z)];
    assert_open(&glass(&sides), "2 of 2 parts,");
}

#[test]
fn closed_meshes_keep_their_volume() {
    // Corners of a cube are apart, for its normals; those of the sphere's seam differ by the sine
    // of 2π.
    let closed = [cube(), turned_over(cube()), mesh(Shape::icosphere(2)), mesh(Shape::uv_sphere(16, 8))];
    for mesh in &closed {
        assert_closed(&glass(std::slice::from_ref(mesh)));
    }
    // Mirrored, and placed twice.
    let mut gltf = glass(&[cube()]);
    let node = gltf.push("nodes", json!({"mesh": 0, "scale": [-1, 2, 3]}));
    gltf.json["scenes"][0]["nodes"] = json!([0, node]);
    assert_closed(&gltf);
    // Without indices.
    let apart: Vec<Vec3> = cube().triangles.as_flattened().iter().map(|&v| cube().positions[v as usize]).collect();
    let mut gltf = glass(&[Mesh { positions: apart, ..cube() }]);
    gltf.primitive().as_object_mut().expect("object").remove("indices");
    assert_closed(&gltf);
}

#[test]
fn a_sheet_that_touches_a_corner_opens_no_box() {
    let scene = glass(&[cube(), sheet()]).load();
    warned(&scene, "is not closed in 1 of 2 parts");
    assert_eq!(scene.meshes.iter().filter(|m| scene.materials[m.material].volume.is_some()).count(), 1);
}

#[test]
fn primitives_close_each_other() {
    let halves = [cut(cube(), |p| p.y < 0.9), cut(cube(), |p| p.y >= 0.9)];
    assert_closed(&glass(&halves));
    assert_open(&glass(&halves[..1]), "1 of 1 part,");
}

#[test]
fn vertices_along_an_edge_are_no_opening() {
    // A lid of four triangles with corners at the middle of the box's edges, where the sides have
    // none.
    let [x, z] = [Vec3::X, Vec3::Z];
    let rim = [Vec3::ZERO, x / 2.0, x, x + z / 2.0, x + z, x / 2.0 + z, z, z / 2.0];
    let positions = [Vec3::splat(0.5) - Vec3::Y / 2.0].into_iter().chain(rim).map(|p| p + Vec3::Y).collect();
    let triangles = (0..8).map(|k| [0, 1 + (k + 1) % 8, 1 + k]).collect();
    let lid = Mesh { positions, triangles, ..Mesh::default() };
    assert_closed(&glass(&[cut(cube(), |p| p.y < 0.9), lid.clone()]));
    assert_open(&glass(&[cut(cube(), |p| p.y < 0.9), moved(lid, Vec3::Y)]), "2 of 2 parts,");
}

#[test]
fn vertices_a_rounding_apart_are_one() {
    let lid = moved(cut(cube(), |p| p.y >= 0.9), Vec3::new(2e-7, -3e-7, 1e-7));
    assert_closed(&glass(&[cut(cube(), |p| p.y < 0.9), lid]));
}

#[test]
fn small_holes_are_reported_and_keep_the_volume() {
    let mut ball = mesh(Shape::icosphere(4));
    ball.triangles.pop();
    let scene = glass(&[ball]).load();
    warned(&scene, "has small holes in 1 of 1 part, where light is wrong: close the mesh");
    assert!(scene.materials[0].volume.is_some());
}

#[test]
fn only_open_parts_of_a_mesh_lose_their_volume() {
    let far = moved(sheet(), Vec3::X * 9.0);
    let vertices = cube().positions.len() as u32;
    let mut both = cube();
    both.positions.extend(&far.positions);
    both.triangles.extend(far.triangles.iter().map(|t| t.map(|v| v + vertices)));
    let mut gltf = glass(&[both]);
    let uvs: Vec<f32> = (0..vertices as usize + far.positions.len()).flat_map(|i| [i as f32, 0.5]).collect();
    let uvs = gltf.accessor(&floats(&uvs), FLOAT, "VEC2", uvs.len() / 2);
    gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    let texture = gltf.texture();
    gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": texture});
    let node = gltf.push("nodes", json!({"mesh": 0, "translation": [0, 0, 5]}));
    gltf.json["scenes"][0]["nodes"] = json!([0, node]);

    let scene = gltf.load();
    warned(&scene, "is not closed in 1 of 2 parts, which is drawn thin-walled");
    let [closed, open]: &[Mesh; 2] = scene.meshes.as_slice().try_into().expect("two meshes");
    assert_eq!((closed.triangles.len(), open.triangles.len(), open.name.as_str()), (12, 2, "pane"));
    let placed: Vec<usize> = scene.instances.iter().map(|i| i.mesh).collect();
    assert_eq!(placed, [0, 1, 0, 1]);
    // Vertices keep their attributes.
    let corner = |scene: &Scene, mesh: usize, triangle: usize| {
        let mesh = &scene.meshes[mesh];
        mesh.triangles[triangle].map(|v| (mesh.positions[v as usize], mesh.uvs[0][v as usize]))
    };
    let [first, second] = [corner(&scene, 1, 0), corner(&scene, 1, 1)];
    for (i, (at, uv)) in first.into_iter().chain(second).enumerate() {
        let vertex = far.triangles.as_flattened()[i];
        assert_eq!((at, uv.x), (far.positions[vertex as usize], (vertices + vertex) as f32));
    }
    // But for the volume, the materials are one.
    let [glass, thin] = [&scene.materials[closed.material], &scene.materials[open.material]];
    assert!(glass.volume.is_some() && thin.volume.is_none());
    assert_eq!(&surelight_scene::Material { volume: glass.volume, ..thin.clone() }, glass);
}

#[test]
fn a_primitive_that_two_meshes_share_is_split_for_both() {
    let mut gltf = glass(&[cube(), sheet()]);
    let copy = gltf.json["meshes"][0].clone();
    gltf.push("meshes", copy);
    gltf.push("nodes", json!({"mesh": 1}));
    gltf.json["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = gltf.load();
    warned(&scene, "1 of 2 parts");
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.triangle_count()), (2, 4, 28));
}

#[test]
fn opaque_volumes_may_be_open() {
    let mut gltf = glass(&[sheet()]);
    gltf.json["materials"][0]["extensions"]["KHR_materials_transmission"] = json!({});
    assert_closed(&gltf);
    gltf.json["materials"][0]["extensions"]["KHR_materials_diffuse_transmission"] =
        json!({"diffuseTransmissionFactor": 0.5});
    assert_open(&gltf, "1 of 1 part,");
}

#[test]
fn vertices_that_are_not_finite_leave_an_opening() {
    let mut broken = cube();
    broken.positions[0] = Vec3::new(f32::NAN, 0.0, f32::INFINITY);
    assert_open(&glass(&[broken]), "1 of 1 part,");
    // None of them, or none with an area.
    let mut gone = cube();
    gone.positions.iter_mut().for_each(|p| p.x = f32::NAN);
    assert_closed(&glass(&[gone]));
    assert_closed(&glass(&[Mesh { triangles: vec![[0, 0, 1], [2, 2, 2]], ..cube() }]));
}
