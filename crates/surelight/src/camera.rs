//! Which camera takes the picture, and how large the picture is.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use surelight_prepare::ActiveClipPlanes;
use surelight_scene::{Camera, ClipRange, Projection, Scene};

use crate::error::Error;
use crate::options::{CameraArgs, Clip};
use crate::parse::{Selector, Size};

/// Pixels on the longer side unless `--size` says otherwise.
const LONGER_SIDE: u32 = 1024;
/// Width over height where neither the file nor `--size` says any.
const DEFAULT_ASPECT: f64 = 4.0 / 3.0;
/// Vertical field of view of `--eye`, degrees.
const DEFAULT_FOV: f64 = 45.0;

/// A camera with its lens and the image it exposes.
#[derive(Debug)]
pub(crate) struct View {
    pub(crate) camera: Camera,
    pub(crate) size: Size,
    pub(crate) lens: Option<Lens>,
    /// An automatic decision, for the summary.
    pub(crate) note: Option<String>,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lens {
    /// Diameter, metres.
    pub(crate) aperture: f32,
    /// Distance of the plane that is sharp, metres.
    pub(crate) focus: f32,
}

/// Chooses the camera of the options, else the file's first, else one that frames the model.
pub(crate) fn choose(scene: &Scene, path: &Path, args: &CameraArgs, size: Option<Size>) -> Result<View, Error> {
    let requested_aspect = size.map(|s| f64::from(s.width) / f64::from(s.height));
    let mut note = None;
    let mut camera = if let (Some(eye), Some(target)) = (args.eye, args.target) {
        look_at(DVec3::from(eye), DVec3::from(target))?
    } else if let Some(wanted) = &args.camera {
        select(scene, path, wanted)?.clone()
    } else if let Some(first) = scene.cameras.first() {
        first.clone()
    } else {
        note = Some("the file has no camera: the whole model is framed (--eye and --target choose a view)".to_owned());
        scene.frame_camera(requested_aspect.unwrap_or(DEFAULT_ASPECT))
    };
    if let Some(degrees) = args.fov {
        let Projection::Perspective { yfov, .. } = &mut camera.projection else {
            return Err(Error::Camera("--fov needs a perspective camera, and this one is orthographic"));
        };
        *yfov = degrees.to_radians();
    }
    if args.clip == Clip::Off {
        camera.clip = ClipRange::NONE;
    }
    let size = size.unwrap_or_else(|| default_size(camera.aspect()));
    let lens = lens(scene, &camera, args)?;
    Ok(View { camera, size, lens, note })
}

/// A warning where the camera's clipping planes cut something off the picture.
pub(crate) fn clipping_warning(camera: &Camera, cut: ActiveClipPlanes) -> Option<String> {
    let ClipRange { near, far } = camera.clip;
    let what = match (cut.near, cut.far) {
        (true, true) => format!("nearer than znear = {near} m and farther than zfar = {far} m"),
        (true, false) => format!("nearer than znear = {near} m"),
        (false, true) => format!("farther than zfar = {far} m"),
        (false, false) => return None,
    };
    let name = if camera.name.is_empty() { "the camera".into() } else { format!("camera \"{}\"", camera.name) };
    Some(format!("{name} does not show surfaces {what} (--clip off shows them)"))
}

/// A camera of the file, by name or else by number.
fn select<'a>(scene: &'a Scene, path: &Path, wanted: &Selector) -> Result<&'a Camera, Error> {
    let by_name = scene.cameras.iter().find(|camera| camera.name == wanted.0);
    let by_number = || wanted.index().and_then(|index| scene.cameras.get(index));
    by_name.or_else(by_number).ok_or_else(|| {
        let list: Vec<_> =
            scene.cameras.iter().enumerate().map(|(i, camera)| format!("{i} \"{}\"", camera.name)).collect();
        let available = match list.len() {
            0 => "the file has none".to_owned(),
            _ => format!("it has {}", list.join(", ")),
        };
        Error::UnknownCamera { path: path.to_owned(), wanted: wanted.0.clone(), available }
    })
}

/// A perspective camera at `eye`, its top towards +Y (towards ∓Z where it faces straight down or
/// up).
fn look_at(eye: DVec3, target: DVec3) -> Result<Camera, Error> {
    let Some(forward) = (target - eye).try_normalize() else {
        return Err(Error::Camera("--eye and --target are the same point; a direction is needed"));
    };
    let right = forward.cross(DVec3::Y).try_normalize().filter(|_| forward.y.abs() < 1.0 - 1e-12).unwrap_or(DVec3::X);
    let up = right.cross(forward);
    Ok(Camera {
        name: String::new(),
        to_world: DAffine3 { matrix3: DMat3::from_cols(right, up, -forward), translation: eye },
        projection: Projection::Perspective { yfov: DEFAULT_FOV.to_radians(), aspect: None },
        clip: ClipRange::NONE,
    })
}

fn lens(scene: &Scene, camera: &Camera, args: &CameraArgs) -> Result<Option<Lens>, Error> {
    let Some(aperture) = args.aperture else { return Ok(None) };
    if matches!(camera.projection, Projection::Orthographic { .. }) {
        return Err(Error::Camera("--aperture needs a perspective camera, and this one is orthographic"));
    }
    let focus = match (args.focus, args.target) {
        (Some(focus), _) => f64::from(focus),
        // A plane of sharpness is as far as its point on the axis; the target is on the axis.
        (None, Some(target)) => camera.to_world.translation.distance(DVec3::from(target)),
        (None, None) => {
            let (low, high) = scene.bounds().unwrap_or_default();
            -camera.to_world.inverse().transform_point3((low + high) / 2.0).z
        }
    };
    if !(focus > 0.0 && focus.is_finite()) {
        return Err(Error::Camera("--aperture needs --focus here: the middle of the model is not before the camera"));
    }
    Ok(Some(Lens { aperture, focus: focus as f32 }))
}

fn default_size(aspect: Option<f64>) -> Size {
    let aspect = aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(DEFAULT_ASPECT);
    let shorter = |ratio: f64| (f64::from(LONGER_SIDE) * ratio).round().max(1.0) as u32;
    if aspect >= 1.0 {
        Size { width: LONGER_SIDE, height: shorter(1.0 / aspect) }
    } else {
        Size { width: shorter(aspect), height: LONGER_SIDE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(name: &str) -> Camera {
        Camera {
            name: name.into(),
            to_world: DAffine3::IDENTITY,
            projection: Projection::Perspective { yfov: 0.5, aspect: Some(2.0) },
            clip: ClipRange::NONE,
        }
    }

    fn args() -> CameraArgs {
        CameraArgs::default()
    }

    #[test]
    fn names_go_before_numbers() {
        let scene = Scene { cameras: vec![camera("a"), camera("b"), camera("0")], ..Scene::default() };
        let find = |wanted: &str| {
            select(&scene, Path::new("x.glb"), &Selector(wanted.into())).map(|camera| camera.name.as_str().to_owned())
        };
        assert_eq!(find("b").unwrap(), "b");
        assert_eq!(find("1").unwrap(), "b");
        assert_eq!(find("0").unwrap(), "0");
        let text = find("3").unwrap_err().to_string();
        assert_eq!(text, "there is no camera \"3\" in \"x.glb\": it has 0 \"a\", 1 \"b\", 2 \"0\"");
    }

    #[test]
    fn clip_off_drops_the_planes() {
        let clip = ClipRange { near: 2.0, far: f64::INFINITY };
        let scene = Scene { cameras: vec![Camera { clip, ..camera("a") }], ..Scene::default() };
        let view = |clip| choose(&scene, Path::new("x.glb"), &CameraArgs { clip, ..args() }, None).unwrap();
        assert_eq!(view(Clip::On).camera.clip, clip);
        assert_eq!(view(Clip::Off).camera.clip, ClipRange::NONE);
        let cut = ActiveClipPlanes { near: true, ..ActiveClipPlanes::default() };
        let text = clipping_warning(&scene.cameras[0], cut).unwrap();
        assert_eq!(text, "camera \"a\" does not show surfaces nearer than znear = 2 m (--clip off shows them)");
        assert_eq!(clipping_warning(&scene.cameras[0], ActiveClipPlanes::default()), None);
    }

    #[test]
    fn sizes_follow_the_aspect() {
        let size = |aspect| {
            let size = default_size(aspect);
            (size.width, size.height)
        };
        assert_eq!(size(Some(2.0)), (1024, 512));
        assert_eq!(size(Some(0.25)), (256, 1024));
        assert_eq!(size(Some(1e-9)), (1, 1024));
        assert_eq!(size(Some(f64::NAN)), (1024, 768));
        assert_eq!(size(None), (1024, 768));
    }

    #[test]
    fn the_view_points_at_its_target_with_the_top_up() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        for target in [DVec3::ZERO, DVec3::new(1.0, -5.0, 3.0), DVec3::new(1.0, 9.0, 3.0), DVec3::new(7.0, 2.0, 3.0)] {
            let camera = look_at(eye, target).unwrap();
            let matrix = camera.to_world.matrix3;
            assert!((matrix.determinant() - 1.0).abs() < 1e-12, "not a rotation");
            assert!((matrix * DVec3::NEG_Z).dot((target - eye).normalize()) > 1.0 - 1e-12);
            assert!(matrix.y_axis.y >= -1e-12, "upside down");
        }
        assert!(look_at(eye, eye).is_err());
    }

    #[test]
    fn focus_is_the_target_unless_given() {
        let scene = Scene { cameras: vec![camera("a")], ..Scene::default() };
        let view = |args: &CameraArgs| choose(&scene, Path::new("x.glb"), args, None);
        let aimed = CameraArgs {
            eye: Some([0.0, 0.0, 5.0]),
            target: Some([0.0, 0.0, 2.0]),
            aperture: Some(0.1),
            fov: Some(90.0),
            ..args()
        };
        let seen = view(&aimed).unwrap();
        assert_eq!(seen.lens, Some(Lens { aperture: 0.1, focus: 3.0 }));
        assert!(matches!(seen.camera.projection, Projection::Perspective { yfov, .. } if yfov == 90f64.to_radians()));
        // The camera is at the empty scene's middle.
        assert!(view(&CameraArgs { aperture: Some(0.1), ..args() }).is_err());
        assert_eq!(view(&args()).unwrap().size, Size { width: 1024, height: 512 });
    }
}
