//! The node hierarchy: transforms, scenes, and graphs that are no tree.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use surelight_scene::{LoadOptions, Scene, load_bytes};

use crate::build::{Gltf, warned};

/// The triangle's file with these nodes; node 0 is the root.
fn with_nodes(nodes: Value) -> Gltf {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"] = nodes;
    gltf
}

fn close(a: DAffine3, b: DAffine3) -> bool {
    a.abs_diff_eq(b, 1e-14)
}

#[test]
fn translation_rotation_scale_apply_from_right_to_left() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let scene = with_nodes(json!([
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, 0, half, half], "scale": [2, 3, -4]},
        {"mesh": 0, "translation": [10, 0, 0]},
    ]))
    .load();
    let parent = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, 3.0, -4.0),
        DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
        DVec3::new(1.0, 2.0, 3.0),
    );
    let world = scene.instances[0].to_world;
    assert!(close(world, parent * DAffine3::from_translation(DVec3::new(10.0, 0.0, 0.0))));
    // x of the child goes to y of the world, scaled by 2.
    assert!((world.translation - DVec3::new(1.0, 22.0, 3.0)).length() < 1e-14);
    assert!(world.matrix3.determinant() < 0.0);
}

#[test]
fn matrices_are_column_by_column() {
    let columns = [1., 2., 3., 0., 4., 5., 6., 0., 7., 8., 10., 0., 11., 12., 13., 1.];
    let scene = with_nodes(json!([{"mesh": 0, "matrix": columns}])).load();
    let m = scene.instances[0].to_world;
    assert_eq!(m.matrix3, DMat3::from_cols_array(&[1., 2., 3., 4., 5., 6., 7., 8., 10.]));
    assert_eq!(m.translation, DVec3::new(11., 12., 13.));
    assert!(scene.warnings.is_empty());

    let mut columns = columns;
    columns[15] = 2.0;
    warned(&with_nodes(json!([{"mesh": 0, "matrix": columns}])).load(), "not affine");
}

#[test]
fn transforms_are_f64() {
    let scene = with_nodes(json!([
        {"children": [1], "translation": [1e9, 0, 0]},
        {"mesh": 0, "translation": [-999_999_999.75, 0, 0]},
    ]))
    .load();
    assert_eq!(scene.instances[0].to_world.translation.x, 0.25);
}

#[test]
fn odd_rotations_are_normalised() {
    let turned = with_nodes(json!([{"mesh": 0, "rotation": [0, 0, 3, 3]}])).load();
    assert!((turned.instances[0].to_world.matrix3.x_axis - DVec3::Y).length() < 1e-15);
    warned(&turned, "rotation of node 0");
    let zero = with_nodes(json!([{"mesh": 0, "rotation": [0, 0, 0, 0]}])).load();
    assert_eq!(zero.instances[0].to_world, DAffine3::IDENTITY);
    warned(&zero, "rotation of node 0");
}

#[test]
fn no_scale_no_picture() {
    // Shrunk to a point: nothing to see. Flattened to a plane: still something.
    assert!(with_nodes(json!([{"mesh": 0, "scale": [0, 0, 0]}])).load().instances.is_empty());
    assert_eq!(with_nodes(json!([{"mesh": 0, "scale": [1, 1, 0]}])).load().instances.len(), 1);
}

#[test]
fn overflowing_transforms_are_left_out() {
    let scene =
        with_nodes(json!([{"children": [1], "scale": [1e200, 1, 1]}, {"mesh": 0, "scale": [1e200, 1, 1]}])).load();
    assert!(scene.instances.is_empty());
    assert!(scene.warnings[0].contains("Node 1") && scene.warnings[0].contains("not finite"), "{:?}", scene.warnings);
}

#[test]
fn graphs_that_are_no_tree_are_refused() {
    with_nodes(json!([{"mesh": 0, "children": [0]}])).refused(&["node 0", "its own child"]);
    with_nodes(json!([{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}])).refused(&["node 2", "node 0", "node 1"]);
    with_nodes(json!([{"children": [1, 1]}, {"mesh": 0}])).refused(&["node 0", "node 1 twice"]);
    with_nodes(json!([{"children": [7]}])).refused(&["node 0", "refers to node 7", "only node 0"]);
    // A cycle that no scene reaches is still no tree.
    with_nodes(json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}])).refused(&["node 1", "cycle"]);
    let mut root_in_cycle = with_nodes(json!([{"children": [1]}, {"children": [0]}]));
    root_in_cycle.refused(&["node 0", "cycle"]);
    root_in_cycle.json["scenes"][0]["nodes"] = json!([1]);
    root_in_cycle.refused(&["cycle"]);
    let mut child_root = with_nodes(json!([{"children": [1]}, {"mesh": 0}]));
    child_root.json["scenes"][0]["nodes"] = json!([1]);
    child_root.refused(&["scene 0", "node 1", "child of node 0"]);
    child_root.json["scenes"][0]["nodes"] = json!([0, 0]);
    child_root.refused(&["scene 0", "node 0 twice"]);
    child_root.json["scenes"][0]["nodes"] = json!([9]);
    child_root.refused(&["scene 0", "node 9", "last one is 1"]);
    with_nodes(json!([{"mesh": 5}])).refused(&["node 0", "mesh 5", "only mesh 0"]);
}

#[test]
fn long_chains_do_not_overflow_the_stack() {
    let count = 200_000;
    let mut nodes: Vec<Value> =
        (1..count).map(|child| json!({"children": [child], "translation": [1, 0, 0]})).collect();
    nodes.push(json!({"mesh": 0}));
    let gltf = with_nodes(json!(nodes));
    // A thread with a small stack, as a viewer may have.
    let scene = std::thread::Builder::new()
        .stack_size(256 << 10)
        .spawn(move || gltf.load())
        .expect("thread")
        .join()
        .expect("no panic");
    assert_eq!(scene.instances[0].to_world.translation.x, f64::from(count - 1));
}

#[test]
fn a_cycle_of_many_nodes_is_found() {
    let count = 20_000;
    let nodes: Vec<Value> = (0..count).map(|i| json!({"children": [(i + 1) % count]})).collect();
    with_nodes(json!(nodes)).refused(&["cycle"]);
}

fn choose(gltf: &Gltf, scene: Option<usize>) -> Result<Scene, String> {
    let options = LoadOptions { scene, ..LoadOptions::default() };
    load_bytes(&gltf.glb(), "made.glb".as_ref(), &options).map_err(|e| e.to_string())
}

#[test]
fn the_scene_is_chosen() {
    let mut gltf =
        with_nodes(json!([{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}, {"mesh": 0, "translation": [7, 0, 0]}]));
    gltf.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}, {}]);
    gltf.json["scene"] = json!(1);
    let x = |scene: &Scene| scene.instances.iter().map(|i| i.to_world.translation.x).collect::<Vec<_>>();
    assert_eq!(x(&choose(&gltf, None).expect("loads")), [5.0]);
    assert_eq!(x(&choose(&gltf, Some(0)).expect("loads")), [0.0]);
    assert_eq!(x(&choose(&gltf, Some(2)).expect("loads")), [] as [f64; 0]);
    assert!(choose(&gltf, Some(3)).expect_err("refused").contains("scene 3"));
    gltf.json["scene"] = json!(3);
    assert!(choose(&gltf, None).expect_err("refused").contains("default scene"));
    gltf.json.as_object_mut().expect("object").remove("scene");
    assert_eq!(x(&choose(&gltf, None).expect("loads")), [0.0]);
    gltf.json.as_object_mut().expect("object").remove("scenes");
    let all = choose(&gltf, None).expect("loads");
    assert_eq!(x(&all), [0.0, 5.0, 7.0]);
    warned(&all, "no scene");
}

#[test]
fn unreachable_meshes_are_not_read() {
    let mut gltf = Gltf::triangle();
    let broken = gltf.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 77}}]}));
    let scene = gltf.load();
    assert_eq!(scene.meshes.len(), 1);
    gltf.json["nodes"][0]["mesh"] = json!(broken);
    gltf.refused(&["accessor 77"]);
}

#[test]
fn hidden_nodes_hide_meshes_and_lights_below_them_but_no_camera() {
    let hidden = |visible: Value| json!({"KHR_node_visibility": {"visible": visible}});
    let mut gltf = with_nodes(json!([
        {"mesh": 0},
        {"children": [2, 3], "extensions": hidden(json!(false)), "camera": 0},
        // Visible itself, but not all that is above it.
        {"mesh": 0, "extensions": hidden(json!(true))},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {}}},
    ]));
    gltf.json["scenes"][0]["nodes"] = json!([0, 1, 4]);
    gltf.json["extensionsUsed"] = json!(["KHR_node_visibility", "KHR_lights_punctual"]);
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    gltf.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]);
    let scene = gltf.load();
    assert_eq!((scene.instances.len(), scene.lights.len(), scene.cameras.len()), (2, 0, 1));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);

    gltf.json["nodes"][1]["extensions"] = hidden(json!(true));
    let scene = gltf.load();
    assert_eq!((scene.instances.len(), scene.lights.len()), (3, 1));

    gltf.json["nodes"][1]["extensions"] = hidden(json!("no"));
    let scene = gltf.load();
    assert_eq!(scene.instances.len(), 3);
    assert!(scene.warnings[0].contains("Whether node 1 is visible"), "{:?}", scene.warnings);
}

#[test]
fn instances_are_limited() {
    let mut gltf = Gltf::triangle();
    let nodes: Vec<Value> = (0..100).map(|_| json!({"mesh": 0})).collect();
    gltf.json["scenes"][0]["nodes"] = json!((0..100).collect::<Vec<_>>());
    gltf.json["nodes"] = json!(nodes);
    assert_eq!(gltf.load().instances.len(), 100);
    let options = LoadOptions { max_instances: 99, ..LoadOptions::default() };
    let message = load_bytes(&gltf.glb(), "made.glb".as_ref(), &options).expect_err("refused").to_string();
    assert!(message.contains("more than 99"), "{message}");
}
