//! Many independent small pictures of one scene.

use surelight_film::Film;
use surelight_render::Renderer;

/// A film of `batches` batches of `samples` samples, the first of them numbered `first`, with one scramble by its first sample.
/// Lost samples are failures.
pub fn film_of(renderer: &mut Renderer<'_>, size: [u32; 2], first: u32, batches: u32, samples: u32) -> Film {
    let mut film = Film::new(size[0], size[1]);
    let numbers = if renderer.key().is_one_sequence() { samples } else { 1 };
    let mut done = 0;
    while done < batches {
        let n = renderer.max_batches().min(batches - done);
        renderer.trace(&mut film, first + done * numbers, n, samples, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        done += n;
    }
    assert_eq!((renderer.counts.dropped, renderer.counts.truncated), (0, 0), "samples were lost");
    film
}
