//! The importer on small files made in memory: one test a feature, one a fault.

mod accessors;
mod build;
mod cameras_and_lights;
mod compressed;
mod container;
mod environment;
mod framing;
mod geometry_extensions;
mod hostile;
mod image_based_light;
mod materials;
mod meshes;
mod nodes;
mod open_volumes;
mod pointers;
mod posing;
mod round_trip;
mod second_opinion;
mod textures;
