//! Options of `surelight measure`.

use std::time::Duration;

use clap::{ArgGroup, Args};

use crate::input::{SceneSource, scene_sources};
use crate::method::{Integrator, MethodArgs};
use crate::options::{CameraArgs, Clip, FileArgs, LightArgs};
use crate::parse::{self as value, Bounces, Selector, Size};

/// `surelight measure SCENE`.
#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("quantity").required(true).args(["point", "irradiance", "region"])),
    after_help = "\
Units are the file's: punctual lights in candela and lux and emission in nit (KHR_lights_punctual, \
KHR_materials_emissive_strength) give irradiance in lux and radiance in nit. Luminance and illuminance are the Rec. 709 \
luminance 0.2126 R + 0.7152 G + 0.0722 B of the result, with no factor of 683 lm/W.

Examples:
  surelight measure room.glb --irradiance 0,0.8,0 --normal 0,1,0 --error 1%
  surelight measure room.glb --point 0,1,3 --direction 0,0,-1 --time 10s
  surelight measure room.glb --region 100,50,140,80 --size 640x480"
)]
pub(crate) struct MeasureArgs {
    /// The scene, a .glb or .gltf file; `-` reads one that needs no other files from standard input
    #[arg(value_name = "SCENE", value_parser = scene_sources())]
    pub(crate) scene: SceneSource,

    /// Radiance that arrives here, metres, from where --direction points
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "direction", allow_hyphen_values = true)]
    pub(crate) point: Option<[f64; 3]>,

    /// Where to look from --point; its length does not matter
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "point", allow_hyphen_values = true)]
    pub(crate) direction: Option<[f64; 3]>,

    /// Irradiance and illuminance here, metres, on a surface that faces --normal
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "normal", allow_hyphen_values = true)]
    pub(crate) irradiance: Option<[f64; 3]>,

    /// What the surface at --irradiance faces; its length does not matter
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "irradiance", allow_hyphen_values = true)]
    pub(crate) normal: Option<[f64; 3]>,

    /// Mean radiance of this part of the image, pixels from the upper left corner; X1 and Y1 are just outside
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = value::rectangle)]
    pub(crate) region: Option<[u32; 4]>,

    /// Pixels of the image that --region is in [default: 1024 on the longer side, the camera's aspect]
    #[arg(long, value_name = "WxH", value_parser = value::size, requires = "region")]
    pub(crate) size: Option<Size>,

    /// Stop at this half width of the interval, relative to the luminance or illuminance; within 10 minutes unless --time is given
    #[arg(long, value_name = "E%", value_parser = value::relative_error)]
    pub(crate) error: Option<f64>,

    /// Confidence of the interval
    #[arg(long, value_name = "C%", value_parser = value::confidence, default_value = "95%")]
    pub(crate) confidence: f64,

    /// Stop after this long, loading included, for example 90s
    #[arg(long, value_name = "TIME", value_parser = value::duration)]
    pub(crate) time: Option<Duration>,

    /// Stop after this many samples, rounded up to whole batches: of the point, or of each pixel of the region
    /// [default: 1048576 and 256, unless --error or --time is given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) spp: Option<u32>,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    /// Scattering events a path may have, that at the measured surface included: 1 direct light, … or `unlimited`
    #[arg(long, value_name = "N", value_parser = value::bounces, default_value = "unlimited")]
    pub(crate) max_bounces: Bounces,

    /// Chooses the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,

    /// Adapter, by part of its name or by its number in `surelight devices` [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) adapter: Option<Selector>,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    /// One JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,

    // Their headings hold for what follows, so they come last.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    #[command(flatten)]
    pub(crate) light: LightArgs,
}

impl MeasureArgs {
    /// What is wrong with the combination, if anything.
    pub(crate) fn conflict(&self) -> Option<&'static str> {
        let CameraArgs { camera, eye, target, fov, aperture, focus, clip } = &self.camera;
        let view = camera.is_some() || eye.is_some() || target.is_some() || fov.is_some();
        let view = view || aperture.is_some() || focus.is_some() || self.size.is_some();
        let view = view || *clip == Clip::Off;
        match self.region {
            None if view => {
                Some("the arguments '--size' and those of the camera need '--region': nothing else is seen by a camera")
            }
            _ if self.method.integrator == Integrator::Caustics => Some(
                "the value 'caustics' of '--integrator' is for pictures: their pixels share light paths, and what is measured has an error bar of \
                 pixels that do not",
            ),
            _ => self.method.conflict(),
        }
    }
}
