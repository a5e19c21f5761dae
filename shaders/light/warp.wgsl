// Points of the unit square with a density given at nine of them, bilinear in between (after Hart
// et al. 2020, "Practical product sampling by fitting and composing warps", section 4, who take the
// four corners).

// Densities, above 0 and up to a common factor, where x and y are 0, at the knot, or 1.
struct Densities {
    knot: vec2f,     // within (0, 1)
    low: vec3f,      // where y is 0
    middle: vec3f,
    high: vec3f,
}

// A point of [0, 1) whose density goes from `a` at 0 to `b` at 1.
fn linear_sample(a: f32, b: f32, u: f32) -> f32 {
    return min(u * (a + b) / (a + sqrt(mix(a * a, b * b, u))), 0.99999994);
}

// Twice the integrals of a density before and after its knot.
fn areas(w: vec3f, knot: f32) -> vec2f {
    return (w.xy + w.yz) * vec2f(knot, 1.0 - knot);
}

fn bent_at(w: vec3f, knot: f32, x: f32) -> f32 {
    return select(mix(w.y, w.z, (x - knot) / (1.0 - knot)), mix(w.x, w.y, x / knot), x < knot);
}

fn bent_sample(w: vec3f, knot: f32, u: f32) -> f32 {
    let area = areas(w, knot);
    let passed = u * (area.x + area.y);
    let before = passed < area.x;
    let ends = select(w.yz, w.xy, before);
    let rest = select((passed - area.x) / area.y, passed / area.x, before);
    let t = linear_sample(ends.x, ends.y, clamp(rest, 0.0, 1.0));
    return select(knot + (1.0 - knot) * t, knot * t, before);
}

// A row's integrals: twice.
fn row_sums(d: Densities) -> vec3f {
    let a = areas(d.low, d.knot.x);
    let b = areas(d.middle, d.knot.x);
    let c = areas(d.high, d.knot.x);
    return vec3f(a.x + a.y, b.x + b.y, c.x + c.y);
}

fn row_at(d: Densities, y: f32) -> vec3f {
    return select(
        mix(d.middle, d.high, (y - d.knot.y) / (1.0 - d.knot.y)),
        mix(d.low, d.middle, y / d.knot.y),
        y < d.knot.y,
    );
}

fn warp_sample(d: Densities, u: vec2f) -> vec2f {
    let y = bent_sample(row_sums(d), d.knot.y, u.y);
    return vec2f(bent_sample(row_at(d, y), d.knot.x, u.x), y);
}

fn warp_pdf(d: Densities, at: vec2f) -> f32 {
    let sums = areas(row_sums(d), d.knot.y);
    return 4.0 * bent_at(row_at(d, at.y), d.knot.x, at.x) / (sums.x + sums.y);
}
