//! Normal, Student-t and χ² distributions: lower tail (`_cdf`), upper tail (`_survival`) and
//! quantile.
//!
//! Tails come from `statrs` (incomplete beta and gamma functions); quantiles invert the smaller
//! tail, so that they keep their accuracy far out, where Šidák's correction over many pixels needs
//! them.

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc_inv;
use std::f64::consts::{PI, SQRT_2};

/// Degrees of freedom from which a t distribution is taken as normal: their tails beyond t differ
/// by about t⁴/(4ν) relatively.
const NORMAL_DOF: f64 = 1e7;

/// P(X ≤ x) of a standard normal variable.
pub fn normal_cdf(x: f64) -> f64 {
    normal_survival(-x)
}

/// P(X > x) of a standard normal variable.
///
/// Half of the upper tail of χ² with one degree of freedom: the library's complementary error
/// function has nine digits only.
pub fn normal_survival(x: f64) -> f64 {
    let half = 0.5 * chi_squared_survival(x * x, 1.0);
    if x < 0.0 { 1.0 - half } else { half }
}

/// The x with P(X ≤ x) = p of a standard normal variable; NaN outside [0, 1].
pub fn normal_quantile(p: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    let tail = p.min(1.0 - p);
    if tail == 0.0 {
        return f64::INFINITY.copysign(p - 0.5);
    }
    let guess = SQRT_2 * erfc_inv(2.0 * tail);
    // One Newton step on the logarithm of the tail takes the library's nine or more digits to full
    // precision.
    let (q, density) = (normal_survival(guess), (-0.5 * guess * guess).exp() / (2.0 * PI).sqrt());
    let x = if density > 0.0 && q > 0.0 { guess + (q / tail).ln() * q / density } else { guess };
    x.copysign(p - 0.5)
}

/// P(T ≤ t) with `dof` degrees of freedom (any positive number, infinity included); NaN elsewhere.
pub fn student_t_cdf(t: f64, dof: f64) -> f64 {
    student_t_survival(-t, dof)
}

/// P(T > t) with `dof` degrees of freedom (any positive number, infinity included); NaN elsewhere.
pub fn student_t_survival(t: f64, dof: f64) -> f64 {
    if t.is_nan() || dof.is_nan() || dof <= 0.0 {
        f64::NAN
    } else if dof >= NORMAL_DOF {
        normal_survival(t)
    } else if t.is_infinite() {
        if t > 0.0 { 0.0 } else { 1.0 }
    } else {
        StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |distribution| distribution.sf(t))
    }
}

/// The t with P(T ≤ t) = p; NaN for p outside [0, 1] or `dof` not positive.
pub fn student_t_quantile(p: f64, dof: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) || dof.is_nan() || dof <= 0.0 {
        return f64::NAN;
    }
    if dof >= NORMAL_DOF {
        return normal_quantile(p);
    }
    let tail = p.min(1.0 - p);
    if tail == 0.0 {
        return f64::INFINITY.copysign(p - 0.5);
    }
    let Ok(distribution) = StudentsT::new(0.0, 1.0, dof) else {
        return f64::NAN;
    };
    let t = invert(|t| distribution.sf(t), |t| distribution.pdf(t), tail, normal_quantile(1.0 - tail).max(0.0));
    t.copysign(p - 0.5)
}

/// P(X ≤ x) of χ² with `dof` degrees of freedom (any positive number); NaN elsewhere.
pub fn chi_squared_cdf(x: f64, dof: f64) -> f64 {
    if x <= 0.0 {
        return if dof > 0.0 { 0.0 } else { f64::NAN };
    }
    ChiSquared::new(dof).map_or(f64::NAN, |distribution| distribution.cdf(x))
}

/// P(X > x) of χ² with `dof` degrees of freedom (any positive number); NaN elsewhere.
pub fn chi_squared_survival(x: f64, dof: f64) -> f64 {
    if x <= 0.0 {
        return if dof > 0.0 { 1.0 } else { f64::NAN };
    }
    if x == f64::INFINITY {
        return if dof > 0.0 { 0.0 } else { f64::NAN };
    }
    ChiSquared::new(dof).map_or(f64::NAN, |distribution| distribution.sf(x))
}

/// The x with P(X ≤ x) = p of χ²; NaN for p outside [0, 1] or `dof` not positive.
pub fn chi_squared_quantile(p: f64, dof: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) || dof.is_nan() || dof <= 0.0 {
        return f64::NAN;
    }
    if p == 0.0 || p == 1.0 {
        return if p == 0.0 { 0.0 } else { f64::INFINITY };
    }
    let Ok(distribution) = ChiSquared::new(dof) else {
        return f64::NAN;
    };
    // Wilson & Hilferty 1931: the cube root of χ²/ν is nearly normal.
    let v = 2.0 / (9.0 * dof);
    let guess = (dof * (1.0 - v + normal_quantile(p) * v.sqrt()).powi(3)).max(0.0);
    if p > 0.5 {
        invert(|x| chi_squared_survival(x, dof), |x| distribution.pdf(x), 1.0 - p, guess)
    } else {
        // The lower tail rises; as a function of 1/x it falls.
        1.0 / invert(
            |y| chi_squared_cdf(1.0 / y, dof),
            |y| distribution.pdf(1.0 / y) / (y * y),
            p,
            if guess > 0.0 { 1.0 / guess } else { 1.0 },
        )
    }
}

/// Solves tail(x) = p for x ≥ 0, where `tail` falls with slope −`density`: Newton steps on ln tail,
/// kept inside a bracket.
fn invert(tail: impl Fn(f64) -> f64, density: impl Fn(f64) -> f64, p: f64, guess: f64) -> f64 {
    let (mut low, mut high) = (0.0, guess.max(1.0));
    while tail(high) > p {
        low = high;
        high *= 2.0;
        if high == f64::INFINITY {
            return high;
        }
    }
    let mut x = guess.clamp(low, high);
    for _ in 0..200 {
        let q = tail(x);
        if q > p {
            low = x;
        } else {
            high = x;
        }
        let newton = x + (q / p).ln() * q / density(x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 4.0 * f64::EPSILON * next.abs() {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found:e} for {expected:e}");
    }

    // Expected values: mpmath 1.3 at 30 digits, by its incomplete beta and gamma functions.

    #[test]
    fn normal_values() {
        for (x, p) in [
            (1.0, 0.158_655_253_931_457_05),
            (3.0, 0.001_349_898_031_630_094_5),
            (8.0, 6.220_960_574_271_784e-16),
            (20.0, 2.753_624_118_606_234e-89),
        ] {
            assert_near(normal_survival(x), p, 1e-12);
            assert_near(1.0 - normal_cdf(x), p, 1e-15 / p + 1e-12);
        }
        for (p, x) in [
            (0.995, 2.575_829_303_548_901),
            (0.9, 1.281_551_565_544_600_5),
            (0.3, -0.524_400_512_708_040_8),
            (1e-10, -6.361_340_902_404_056),
            (1e-300, -37.047_096_299_361_2),
        ] {
            assert_near(normal_quantile(p), x, 1e-12);
        }
        assert_eq!(normal_quantile(0.5).abs(), 0.0);
        assert_eq!(normal_quantile(0.0), f64::NEG_INFINITY);
        assert!(normal_quantile(1.1).is_nan());
    }

    #[test]
    fn student_t_values() {
        for (dof, tail, t) in [
            (15.0, 0.0005, 4.072_765_195_903_792),
            (15.0, 0.025, 2.131_449_545_559_776),
            (1.0, 0.025, 12.706_204_736_174_705),
            (2.5, 0.01, 5.353_111_173_030_874),
            (30.0, 0.005, 2.749_995_653_567_225),
            (1000.0, 0.0005, 3.300_282_648_423_913),
            (15.0, 1e-8, 10.714_732_022_790_736),
        ] {
            assert_near(student_t_quantile(tail, dof), -t, 1e-11);
            assert_near(student_t_quantile(1.0 - tail, dof), t, 1e-7 / tail.sqrt() * 1e-3);
            assert_near(student_t_survival(t, dof), tail, 1e-11);
        }
        for (t, dof, tail) in [
            (2.0, 3.0, 0.069_662_984_279_421_6),
            (3.5, 1e5, 2.327_302_696_855_501_3e-4),
            (3.5, 1e6, 2.326_391_968_405_175e-4),
            (3.5, 1e7, 2.326_300_908_034_245_7e-4),
            (0.1, 7.5, 0.461_482_666_033_895),
            (40.0, 15.0, 5.845_330_620_433_199e-17),
        ] {
            let tolerance = if dof >= NORMAL_DOF { 5e-6 } else { 1e-9 };
            assert_near(student_t_survival(t, dof), tail, tolerance);
            assert_near(student_t_cdf(t, dof), 1.0 - tail, tolerance);
        }
        assert_eq!(student_t_survival(1.5, f64::INFINITY), normal_survival(1.5));
        assert!(student_t_survival(1.0, 0.0).is_nan() && student_t_quantile(0.5, -1.0).is_nan());
    }

    #[test]
    fn chi_squared_values() {
        for (x, dof, tail) in [
            (18.307038053275146, 10.0, 0.05),
            (1.0, 1.0, 0.317_310_507_862_914_1),
            (150.0, 100.0, 9.039_320_423_540_09e-4),
            (0.5, 6.0, 0.997_838_503_310_237_5),
            (1200.0, 1000.0, 1.225_594_233_062_290_4e-5),
            (300.0, 20.0, 8.082_849_629_775_91e-52),
        ] {
            assert_near(chi_squared_survival(x, dof), tail, 1e-11);
            assert_near(chi_squared_cdf(x, dof), 1.0 - tail, 1e-11);
        }
        for (dof, tail, x) in [
            (10.0, 0.05, 18.307038053275146),
            (1.0, 0.01, 6.634_896_601_021_215),
            (63.0, 0.01, 92.010_023_614_132),
            (500.5, 1e-6, 665.532_741_897_977),
        ] {
            assert_near(chi_squared_quantile(1.0 - tail, dof), x, 1e-10);
        }
        assert_near(chi_squared_quantile(0.001, 3.0), 0.024_297_585_815_692_73, 1e-10);
        assert_eq!((chi_squared_cdf(0.0, 3.0), chi_squared_survival(-1.0, 3.0)), (0.0, 1.0));
        assert!(chi_squared_survival(1.0, 0.0).is_nan());
    }
}
