//! Light from far away: `--env`, `--sky`, or a white sky for a file that has no light at all.

use surelight_scene::{Environment, Scene, load_environment_with_warnings};

use crate::error::Error;
use crate::options::LightArgs;

impl LightArgs {
    /// Rotation of the map about the vertical axis, degrees.
    pub(crate) fn env_rotation(&self) -> f32 {
        self.env_rotate.unwrap_or(0.0)
    }

    /// Factor on the radiance of the map.
    pub(crate) fn env_scale(&self) -> f32 {
        self.env_scale.unwrap_or(1.0)
    }
}

/// Sets the scene's environment by the options; returns a note on an automatic decision.
pub(crate) fn set(scene: &mut Scene, args: &LightArgs) -> Result<Option<String>, Error> {
    if let Some(file) = &args.env {
        let (map, warnings) = load_environment_with_warnings(file)?;
        scene.warnings.extend(warnings);
        scene.environment = Some(Environment::Map {
            map: map.into(),
            rotation: args.env_rotation().to_radians(),
            scale: args.env_scale(),
        });
    } else if let Some(radiance) = args.sky {
        scene.environment = Some(Environment::Uniform(radiance));
    } else if !scene.has_light() {
        scene.environment = Some(Environment::Uniform([1.0; 3]));
        let note = "the file has no light: a uniform white sky was added (--env and --sky choose another)";
        return Ok(Some(note.to_owned()));
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(sky: Option<[f32; 3]>) -> LightArgs {
        LightArgs { env: None, env_rotate: None, env_scale: None, sky }
    }

    #[test]
    fn a_dark_file_gets_a_white_sky_and_a_note() {
        let mut scene = Scene::default();
        assert!(set(&mut scene, &args(None)).unwrap().is_some());
        assert_eq!(scene.environment, Some(Environment::Uniform([1.0; 3])));
    }

    #[test]
    fn a_chosen_sky_is_taken_even_if_black() {
        let mut scene = Scene::default();
        assert_eq!(set(&mut scene, &args(Some([0.0; 3]))).unwrap(), None);
        assert_eq!(scene.environment, Some(Environment::Uniform([0.0; 3])));
    }
}
