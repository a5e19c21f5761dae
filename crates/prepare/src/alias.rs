//! Alias tables: choosing one of many by weight in constant time.

/// One slot: keep the slot's own index with probability `threshold`, else take `alias`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot {
    pub(crate) threshold: f32,
    pub(crate) alias: u32,
}

/// Vose's construction (IEEE Trans. Software Eng. 17(9), 1991) in f64. All weights must be finite
/// and ≥ 0, one above 0.
pub(crate) fn alias_table(weights: &[f64]) -> Vec<Slot> {
    let total: f64 = weights.iter().sum();
    let mut scaled: Vec<f64> = weights.iter().map(|w| w * weights.len() as f64 / total).collect();
    let mut slots: Vec<Slot> = (0..weights.len()).map(|i| Slot { threshold: 1.0, alias: i as u32 }).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..weights.len()).partition(|&i| scaled[i] < 1.0);
    while let (Some(s), Some(&l)) = (small.pop(), large.last()) {
        slots[s] = Slot { threshold: scaled[s] as f32, alias: l as u32 };
        scaled[l] -= 1.0 - scaled[s];
        if scaled[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    // The rest on either side is 1 up to rounding; a weight of 0 must nevertheless stay
    // unreachable.
    if let Some(heaviest) = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])) {
        for (slot, &weight) in slots.iter_mut().zip(weights) {
            if weight == 0.0 && slot.threshold > 0.0 {
                *slot = Slot { threshold: 0.0, alias: heaviest as u32 };
            }
        }
    }
    slots
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probability of each index that a table gives.
    fn probabilities(table: &[Slot]) -> Vec<f64> {
        let mut p = vec![0.0; table.len()];
        for (i, slot) in table.iter().enumerate() {
            p[i] += f64::from(slot.threshold) / table.len() as f64;
            p[slot.alias as usize] += (1.0 - f64::from(slot.threshold)) / table.len() as f64;
        }
        p
    }

    #[test]
    fn gives_each_weight_its_share() {
        for weights in
            [vec![1.0], vec![1.0, 0.0, 3.0], vec![1e-9, 1.0, 5.0, 0.0, 1e3, 2.0], (0..999).map(f64::from).collect()]
        {
            let total: f64 = weights.iter().sum();
            for (p, w) in probabilities(&alias_table(&weights)).iter().zip(&weights) {
                assert!((p - w / total).abs() < 1e-7, "{p} against {}", w / total);
                assert!(*w > 0.0 || *p == 0.0);
            }
        }
    }
}
