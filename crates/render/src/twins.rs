//! The records that host code lays out by itself, stated for comparison with what composed shaders say.

use std::collections::HashMap;

use bytemuck::Zeroable;
use surelight_film::BatchSum;

use crate::{
    pass::{Control, EmissionPass, FeaturePixel, Pass},
    prepare::{AreaLight, InstanceRows, LightEntry, LightNode, LightPath, PunctualLight, TextureUse, View},
    reflect::RecordLayout,
};

/// Offsets and sizes of a `repr(C)` struct's fields, all of them: one that is left out does not compile.
macro_rules! layout {
    ($record:ident { $($field:ident),+ }) => {{
        let $record { $($field),+ } = $record::zeroed();
        let fields = [$((stringify!($field), std::mem::offset_of!($record, $field), size_of_val(&$field))),+];
        RecordLayout {
            offsets: fields.iter().map(|&(name, offset, _)| (name.to_owned(), offset as u32)).collect::<HashMap<_, _>>(),
            sizes: fields.iter().map(|&(name, _, size)| (name.to_owned(), size as u32)).collect::<HashMap<_, _>>(),
            span: size_of::<$record>() as u32,
        }
    }};
}

/// Each record of fixed layout that the host shares with shaders, by its name in WGSL.
///
/// Fields called `pad…` are what WGSL inserts by itself.
pub fn host_layouts() -> Vec<(&'static str, RecordLayout)> {
    vec![
        (
            "View",
            layout!(View {
                origin,
                lens_radius,
                right,
                focus,
                up,
                seed,
                forward,
                max_bounces,
                environment,
                environment_rotation,
                size,
                environment_size,
                environment_probability,
                light_density,
                light_count,
                max_radiance
            }),
        ),
        ("Pass", layout!(Pass { corner, size, first_batch, batches, samples, budget, lanes, threads, restart, walks })),
        (
            "EmissionPass",
            layout!(EmissionPass {
                corner,
                size,
                replicate,
                sequence,
                first,
                count,
                length,
                budget,
                lanes,
                restart,
                worth,
                quantum,
                square_quantum,
                unused
            }),
        ),
        ("Control", layout!(Control { workgroups, unfinished, rays, paths, dropped, truncated })),
        ("BatchSum", layout!(BatchSum { sum, tail })),
        ("Feature", layout!(FeaturePixel { albedo, depth, normal, unused })),
        ("LightEntry", layout!(LightEntry { threshold, alias_entry, probability, light })),
        ("AreaLight", layout!(AreaLight { v0, prim, e1, shape, e2, weight })),
        ("LightNode", layout!(LightNode { center, variance, normal_xy, normal_z, power, link })),
        ("LightPath", layout!(LightPath { trail, inverse_area, unused })),
        ("PunctualLight", layout!(PunctualLight { position, kind, intensity, angle_scale, direction, angle_offset })),
        ("TextureUse", layout!(TextureUse { offset, width, height, flags, row_u, pad_0, row_v, pad_1 })),
        (
            "Instance",
            layout!(InstanceRows {
                world_x,
                world_y,
                world_z,
                object_x,
                first_light,
                object_y,
                pad_0,
                object_z,
                pad_1
            }),
        ),
    ]
}
