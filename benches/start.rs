//! From a file to the first sample of each pixel, stage by stage: `cargo bench --bench start --
//! SCENE…`.
//!
//! The stages are those of a render, one after the other, in this process: wall seconds, and
//! processor seconds of all threads, which other work on the machine changes less. The first scene
//! finds the driver cold, as a fresh process does; run one scene at a time to have each cold. The
//! caches of files and of the driver's compiled kernels are unchanged: `sync; echo 3 >
//! /proc/sys/vm/drop_caches` empties the former, `MESA_SHADER_CACHE_DISABLE=1` does without the
//! latter on Mesa's drivers.

use std::path::Path;
use std::time::Instant;

use surelight_bench::conditions::cpu_seconds;
use surelight_film::Film;
use surelight_prepare::{Prepared, Settings};
use surelight_render::{AdapterChoice, Device, PrecompiledKernel, Renderer};
use surelight_scene::{Environment, LoadOptions};

const SIZE: u32 = 256;

/// The clock of the stages: wall and processor seconds since the last.
struct Clock(Instant, f64);

impl Clock {
    fn lap(&mut self, stage: &str) {
        let (wall, cpu) = (self.0.elapsed().as_secs_f64(), cpu_seconds().unwrap_or(f64::NAN));
        println!("| {stage} | {wall:.3} | {:.3} |", cpu - self.1);
        *self = Self(Instant::now(), cpu);
    }
}

fn main() {
    for file in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        println!("{file}\n| stage | wall s | processor s |\n|---|---|---|");
        let mut clock = Clock(Instant::now(), cpu_seconds().unwrap_or(f64::NAN));
        let mut scene =
            surelight_scene::load(Path::new(&file), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        clock.lap("load");
        if !scene.has_light() {
            scene.environment = Some(Environment::Uniform([1.0; 3]));
        }
        let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
        let device = Device::new(&AdapterChoice::Best).unwrap_or_else(|e| panic!("{e}"));
        clock.lap("device");
        // As a render does it: the kernel is compiled on this thread, trees are built on the
        // others.
        let mut compiling = f64::NAN;
        let settings = Settings::new(SIZE, SIZE);
        let (prepared, precompiled) = Prepared::with_work(&scene, &camera, &settings, |blueprint| {
            let started = Instant::now();
            let precompiled = PrecompiledKernel::compile(&device, blueprint);
            compiling = started.elapsed().as_secs_f64();
            precompiled
        })
        .unwrap_or_else(|e| panic!("{file}: {e}"));
        clock.lap("BVH, lights, textures; composing and compiling beside them");
        println!("| of it composing and compiling | {compiling:.3} | |");
        let precompiled = precompiled.unwrap_or_else(|e| panic!("{file}: {e}"));
        let mut renderer =
            Renderer::with_kernel(&device, &prepared, precompiled).unwrap_or_else(|e| panic!("{file}: {e}"));
        clock.lap("upload, the first-hit kernel");
        println!("| of it upload | {:.3} | |", renderer.upload_seconds);
        let mut film = Film::new(SIZE, SIZE);
        renderer.trace(&mut film, 0, 1, 1, &mut |_| true).unwrap_or_else(|e| panic!("{file}: {e}"));
        clock.lap("first sample");
        renderer.trace_features(&mut film).unwrap_or_else(|e| panic!("{file}: {e}"));
        clock.lap("first-hit features");
    }
}
