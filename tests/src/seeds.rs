//! Many independent small pictures of one scene.

use surelight_film::Film;
use surelight_render::{Position, Renderer, sample_batches};

/// A film of `batches` batches of `samples` samples, the first of them numbered `first`, with one
/// scramble by its first sample. Lost samples are failures.
pub fn film_of(renderer: &mut Renderer<'_>, size: [u32; 2], first: u32, batches: u32, samples: u32) -> Film {
    let mut film = Film::new(size[0], size[1]);
    sample_batches(renderer, &mut film, Position::numbered(first), batches, samples).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((renderer.counts.dropped, renderer.counts.truncated), (0, 0), "samples were lost");
    film
}
