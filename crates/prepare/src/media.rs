//! Volumes within one another: whether there are any, and which wins where two overlap.
//!
//! glTF gives volumes no order. Smaller ones are ranked higher: a volume that is wholly inside
//! another is smaller, so that ice takes precedence in water and water in a glass. Where two merely
//! overlap, the smaller takes precedence.

use glam::DVec3;
use surelight_scene::{Instance, Scene};

use super::lobes::transmits;

/// Number of placements beyond which overlap is assumed and not tested.
const MANY: usize = 2000;

/// For each material a word: its rank, from 1 for the largest, above its index; 0 where it encloses
/// no medium. Empty where no volumes can overlap, or where there are too many materials for words.
pub(crate) fn rank(scene: &Scene) -> Vec<u32> {
    let material_of = |i: &Instance| scene.meshes[i.mesh].material;
    let encloses = |i: &&Instance| {
        let material = &scene.materials[material_of(i)];
        material.volume.is_some() && transmits(material)
    };
    let placed: Vec<(usize, [DVec3; 2])> =
        scene.instances.iter().filter(encloses).filter_map(|i| Some((material_of(i), bounds(scene, i)?))).collect();
    let overlap = |a: &[DVec3; 2], b: &[DVec3; 2]| a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all();
    let nested = placed.len() > MANY
        || placed.iter().enumerate().any(|(k, (_, a))| placed[..k].iter().any(|(_, b)| overlap(a, b)));
    if !nested || scene.materials.len() > usize::from(u16::MAX) {
        return Vec::new();
    }
    let mut sizes = vec![0.0_f64; scene.materials.len()];
    for (material, [low, high]) in &placed {
        sizes[*material] = sizes[*material].max((*high - *low).length());
    }
    let mut by_size: Vec<usize> = (0..sizes.len()).filter(|&m| sizes[m] > 0.0).collect();
    by_size.sort_by(|&a, &b| sizes[b].total_cmp(&sizes[a]));
    let mut words = vec![0; sizes.len()];
    for (rank, &material) in (1_u32..).zip(&by_size) {
        words[material] = rank << 16 | material as u32;
    }
    words
}

/// Corners of the box, along the world's axes, around the placed box of a mesh; `None` for one
/// without a finite vertex.
fn bounds(scene: &Scene, instance: &Instance) -> Option<[DVec3; 2]> {
    let vertices = scene.meshes[instance.mesh].positions.iter().map(|p| p.as_dvec3()).filter(|p| p.is_finite());
    let [low, high] = vertices.fold(None, |found: Option<[DVec3; 2]>, p| {
        Some(found.map_or([p, p], |[low, high]| [low.min(p), high.max(p)]))
    })?;
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let m = instance.to_world.matrix3;
    let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    let middle = instance.to_world.transform_point3(middle);
    Some([middle - reach, middle + reach])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use surelight_scene::{Material, Volume};
    use surelight_scenes::shapes::Shape;

    /// Glass cubes by half their sides and places along x.
    fn cubes(all: &[(f64, f64)]) -> Scene {
        let mut scene = Scene::default();
        for &(half, x) in all {
            let volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
            scene.materials.push(Material { transmission: 1.0, volume: Some(volume), ..Material::default() });
            let shape = Shape::cuboid(DVec3::splat(-half), DVec3::splat(half));
            scene.meshes.push(shape.bare().into_mesh("", scene.materials.len() - 1, false));
            let to_world = DAffine3::from_translation(DVec3::X * x);
            scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world });
        }
        scene
    }

    #[test]
    fn inner_volumes_rank_higher() {
        assert_eq!(rank(&cubes(&[(1.0, 0.0), (2.0, 0.5), (0.5, 0.0)])), [2 << 16, 1 << 16 | 1, 3 << 16 | 2]);
    }

    #[test]
    fn disjoint_volumes_have_no_rank() {
        assert!(rank(&cubes(&[(1.0, 0.0), (1.0, 2.5), (0.5, 9.0)])).is_empty());
        let mut opaque = cubes(&[(1.0, 0.0), (2.0, 0.0)]);
        opaque.materials[1].transmission = 0.0;
        assert!(rank(&opaque).is_empty());
    }
}
