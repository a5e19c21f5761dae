//! Mutations for the group `numeric`.

use super::Mutation;

const BINARY: &str = "torture_numeric";

pub(super) const ROWS: &[Mutation] = &[Mutation {
    case: 1,
    mistake: "an albedo that is a millionth too large",
    file: "shaders/bsdf/bsdf.wesl",
    from: "return BsdfSample(wi, b.base_color, lambert_pdf_solid_angle(wi), false, true);",
    to: "return BsdfSample(wi, 1.000001 * b.base_color, lambert_pdf_solid_angle(wi), false, true);",
    binary: BINARY,
    test: "furnace::zero_variance_furnace",
}];
