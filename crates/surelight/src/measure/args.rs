//! Options of `surelight measure`.

use std::time::Duration;

use clap::{ArgGroup, Args};

use crate::input::{SceneSource, scene_sources};
use crate::method::{Integrator, MethodArgs};
use crate::options::{CameraArgs, Clip, FileArgs, LightArgs, heading};
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
    /// Scene to measure, a .glb or .gltf file; `-` reads one without external files from standard
    /// input
    #[arg(value_name = "SCENE", value_parser = scene_sources())]
    pub(crate) scene: SceneSource,

    /// Measure the incident radiance at this point from --direction, in metres
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "direction", allow_hyphen_values = true)]
    pub(crate) point: Option<[f64; 3]>,

    /// Direction of the ray from --point, of any length
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "point", allow_hyphen_values = true)]
    pub(crate) direction: Option<[f64; 3]>,

    /// Measure irradiance and illuminance at this point, in metres, on a surface that faces
    /// --normal
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "normal", allow_hyphen_values = true)]
    pub(crate) irradiance: Option<[f64; 3]>,

    /// Normal of the surface at --irradiance, of any length
    #[arg(long, value_name = "x,y,z", value_parser = value::point, requires = "irradiance", allow_hyphen_values = true)]
    pub(crate) normal: Option<[f64; 3]>,

    /// Measure the mean radiance of this rectangle of pixels; X1 and Y1 are excluded
    ///
    /// Pixels are counted from the upper left corner.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = value::rectangle)]
    pub(crate) region: Option<[u32; 4]>,

    /// Resolution of the image that --region is in [default: 1024 on the longer side]
    #[arg(long, value_name = "WxH", value_parser = value::size, requires = "region")]
    pub(crate) size: Option<Size>,

    /// Relative error to stop at, for example 1%
    ///
    /// The half-width of the confidence interval, relative to the luminance or illuminance. Stops
    /// after 10 minutes unless --time is given.
    #[arg(long, value_name = "E%", value_parser = value::relative_error)]
    pub(crate) error: Option<f64>,

    /// Confidence level of the interval
    #[arg(long, value_name = "C%", value_parser = value::confidence, default_value = "95%")]
    pub(crate) confidence: f64,

    /// Time to stop at, loading included, for example 90s
    #[arg(long, value_name = "TIME", value_parser = value::duration)]
    pub(crate) time: Option<Duration>,

    /// Samples to stop at: of the point, or of each pixel of the region
    ///
    /// Rounded up to whole batches. The default is 1048576 for a point and 256 for a region, unless
    /// --error or --time is given.
    #[arg(long, value_name = "N", value_parser = value::count)]
    pub(crate) spp: Option<u32>,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    /// Limit paths to N scattering events; biased
    ///
    /// The event at the measured surface is the first: 1 is direct light. By default paths have no
    /// limit and end by Russian roulette.
    #[arg(
        long,
        value_name = "N",
        value_parser = value::bounces,
        default_value = "unlimited",
        help_heading = heading::SAMPLING
    )]
    pub(crate) max_bounces: Bounces,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = heading::SAMPLING)]
    pub(crate) seed: u32,

    /// Adapter to measure on, by name or index [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector, help_heading = heading::DEVICE)]
    pub(crate) adapter: Option<Selector>,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    /// Print one JSON object
    #[arg(long, help_heading = heading::DEVICE)]
    pub(crate) json: bool,

    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    #[command(flatten)]
    pub(crate) light: LightArgs,
}

impl MeasureArgs {
    /// The error in the combination, if any.
    pub(crate) fn conflict(&self) -> Option<&'static str> {
        let CameraArgs { camera, eye, target, fov, aperture, focus, clip } = &self.camera;
        let view = camera.is_some() || eye.is_some() || target.is_some() || fov.is_some();
        let view = view || aperture.is_some() || focus.is_some() || self.size.is_some();
        let view = view || *clip == Clip::Off;
        match self.region {
            None if view => Some(
                "the arguments '--size' and those of the camera need '--region': no other measurement has a camera",
            ),
            _ if self.method.integrator == Integrator::Caustics => Some(
                "the value 'caustics' of '--integrator' is for pictures: their pixels share light paths, and a measurement has an error bar of \
                 pixels that do not",
            ),
            _ => self.method.conflict(),
        }
    }
}
