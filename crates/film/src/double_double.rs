//! Arithmetic on unevaluated sums of two doubles.

/// An unevaluated sum `hi + lo` of two doubles with `|lo| ≤ ulp(hi)/2`.
///
/// Algorithms: Dekker, "A floating-point technique for extending the available precision", Numer.
/// Math. 18 (1971); error bounds: Joldes, Muller, Popescu, "Tight and rigorous error bounds for
/// basic building blocks of double-word arithmetic", ACM TOMS 44(2) (2017), algorithms 4, 6, 9, 12
/// and 15.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DoubleDouble {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

/// Knuth's TwoSum: `a + b` as rounded sum and exact error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

/// Dekker's Fast2Sum, for `|a| ≥ |b|`.
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// `a · b` as rounded product and exact error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl DoubleDouble {
    /// The two words, `hi` first: the state that a checkpoint keeps.
    pub fn words(self) -> [f64; 2] {
        [self.hi, self.lo]
    }

    /// From two words, renormalised.
    pub fn from_words([hi, lo]: [f64; 2]) -> Self {
        let (hi, lo) = two_sum(hi, lo);
        Self { hi, lo }
    }

    /// The value rounded to a double.
    pub fn to_f64(self) -> f64 {
        self.hi
    }

    /// Adds a double; relative error below 2⁻¹⁰⁴ of the result.
    pub fn add_f64(&mut self, x: f64) {
        let (sum, error) = two_sum(self.hi, x);
        (self.hi, self.lo) = fast_two_sum(sum, self.lo + error);
    }

    /// Adds another; relative error below 3·2⁻¹⁰⁶ of the result (Joldes et al., algorithm 6).
    pub fn add(&mut self, other: Self) {
        let (s, e) = two_sum(self.hi, other.hi);
        let (t, f) = two_sum(self.lo, other.lo);
        let (v, w) = fast_two_sum(s, e + t);
        (self.hi, self.lo) = fast_two_sum(v, f + w);
    }

    pub(crate) fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        let (p, e) = two_product(self.hi, other.hi);
        let cross = self.hi.mul_add(other.lo, self.lo * other.hi);
        let (hi, lo) = fast_two_sum(p, e + cross);
        Self { hi, lo }
    }

    pub(crate) fn times_f64(self, x: f64) -> Self {
        let (p, e) = two_product(self.hi, x);
        let (hi, lo) = fast_two_sum(p, self.lo.mul_add(x, e));
        Self { hi, lo }
    }

    pub(crate) fn over_f64(self, x: f64) -> Self {
        let quotient = self.hi / x;
        let (p, e) = two_product(quotient, x);
        let rest = (self.hi - p) - e + self.lo;
        let (hi, lo) = fast_two_sum(quotient, rest / x);
        Self { hi, lo }
    }
}
