//! Case 11: rays that leave a surface, by the kernel's own offset, neither hit it again nor get out
//! of a closed room.

use glam::{DAffine3, DVec3};
use surelight_accel::Instancing;
use surelight_scenes::shapes::Shape;
use surelight_tests::respawn::{assert_none, check, room};

#[test]
fn respawn() {
    let cube = || Shape::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let hall = || Shape::cuboid(DVec3::splat(-1.0), DVec3::new(40.0, 1.0, 300.0));
    let eye = DVec3::new(0.0, 0.2, 5.0);
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let rooms = [
        ("cube", room(cube(), DVec3::new(0.3, 0.25, 0.9)), 2.0),
        ("turned cube", room(cube().transformed(&turn), DVec3::new(0.2, 0.25, 0.3)), 2.0),
        ("hall", room(hall(), eye), 300.0),
        ("turned hall", room(hall().transformed(&turn), turn.transform_point3(eye)), 300.0),
        ("ball", room(Shape::icosphere(3).faceted(), DVec3::ZERO), 2.0),
        ("slivers", room(Shape::uv_sphere(200, 4).faceted().bare(), DVec3::ZERO), 2.0),
        ("least cube", room(cube().placed(1e-8, DVec3::ZERO), DVec3::new(3e-9, 2e-9, 9e-9)), 2e-8),
        ("greatest cube", room(cube().placed(1e8, DVec3::ZERO), DVec3::new(3e7, 2e7, 9e7)), 2e8),
        ("tiny cube", room(cube().placed(1e-6, DVec3::ZERO), DVec3::new(3e-7, 2e-7, 9e-7)), 2e-6),
        ("huge cube", room(cube().placed(1e6, DVec3::ZERO), DVec3::new(3e5, 2e5, 9e5)), 2e6),
    ];
    assert_none(rooms.iter().map(|(name, scene, size)| check(name, scene, Instancing::Never, *size)));
}

#[test]
fn respawn_in_instances() {
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let rooms =
        [("turned", DVec3::ONE), ("stretched", DVec3::new(0.1, 1.0, 7.0)), ("mirrored", DVec3::new(-2.0, 1.0, 1.0))];
    let failures = rooms.iter().map(|(name, scale)| {
        let cube = Shape::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0)).transformed(&turn);
        let mut scene = room(cube, DVec3::ZERO);
        scene.instances[0].to_world = turn * DAffine3::from_scale(*scale);
        check(name, &scene, Instancing::Always, 2.0 * scale.abs().max_element() as f32)
    });
    assert_none(failures);
}
