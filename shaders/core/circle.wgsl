// The unit circle, without the device's own sine and cosine: Vulkan requires an accuracy of only
// 2⁻¹¹ of those, and none outside [−π, π], and directions that are not of unit length corrupt all
// results.

// The point at u turns, u in [0, 1]. Error and deviation from unit length below 2e-7: minimax
// polynomials on an eighth of a turn to either side of the nearest quarter.
fn unit_circle(u: f32) -> vec2f {
    let quarter = floor(4.0 * u + 0.5);
    let r = (4.0 * u - quarter) * 1.5707963267949;
    let r2 = r * r;
    let s = r + r * r2 * (-0.16666651 + r2 * (0.00833197866 + r2 * -0.000194956362));
    let c = 1.0 + r2 * (-0.5 + r2 * (0.0416666469 + r2 * (-0.00138873675 + r2 * 2.44384516e-5)));
    let q = u32(quarter);
    let turned = select(vec2f(c, s), vec2f(s, c), (q & 1u) != 0u);
    return select(turned, -turned, vec2<bool>(((q + 1u) & 2u) != 0u, (q & 2u) != 0u));
}
