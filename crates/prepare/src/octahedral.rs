//! Unit vectors in 32 bits: octahedral coordinates of 16 bits each (Cigolle et al. 2014, JCGT
//! 3(2)).

use glam::Vec3;

/// Packs a direction of any length; 0, which is +Z, where it has none. Counterpart of
/// `octahedral_encode` in `shaders/core/math.wesl`.
pub(crate) fn octahedral(n: Vec3) -> u32 {
    let sum = n.x.abs() + n.y.abs() + n.z.abs();
    if sum == 0.0 || !sum.is_finite() {
        return 0;
    }
    let (mut x, mut y) = (n.x / sum, n.y / sum);
    if n.z < 0.0 {
        (x, y) = ((1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum());
    }
    let snorm = |v: f32| (v.clamp(-1.0, 1.0) * 32767.0).round() as i32 as u16 as u32;
    snorm(x) | snorm(y) << 16
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    /// Counterpart of `octahedral_decode` in `shaders/core/math.wesl`.
    fn octahedral_decode(bits: u32) -> Vec3 {
        let unpack = |word: u32| (f32::from(word as u16 as i16) / 32767.0).max(-1.0);
        let e = Vec2::new(unpack(bits & 0xffff), unpack(bits >> 16));
        let z = 1.0 - e.x.abs() - e.y.abs();
        let t = (-z).max(0.0);
        let fold = |v: f32| if v >= 0.0 { v - t } else { v + t };
        Vec3::new(fold(e.x), fold(e.y), z).normalize()
    }

    #[test]
    fn directions_come_back() {
        for i in 0..1000 {
            let (a, z) = (f64::from(i) * 2.399_963, 1.0 - 2.0 * (f64::from(i) + 0.5) / 1000.0);
            let r = (1.0 - z * z).sqrt();
            let n = Vec3::new((r * a.cos()) as f32, (r * a.sin()) as f32, z as f32);
            let back = octahedral_decode(octahedral(n * 3.0));
            assert!((back - n).length() < 1e-4, "{n} became {back}");
        }
        assert_eq!(octahedral_decode(octahedral(Vec3::ZERO)), Vec3::Z);
    }
}
