//! The one-sentence answer.

use crate::{
    analysis::{Interval, ratio},
    data::SceneData,
};

use super::text::{factor, level, seconds};

/// The fastest method to an error, and its lead: "mis/sobol reaches 2 % in 3.1 s, 4.2 × (3.9
/// to 4.6) sooner than area/sobol".
///
/// The level is the finest that two methods without bias reached in every repeat; where only one
/// reached any, it is the finest of that one.
pub fn answer(scene: &SceneData) -> String {
    let levels = scene.levels();
    let shared = levels.iter().rev().find(|&&e| scene.ranking(e, false).len() >= 2);
    let alone = || levels.iter().rev().find(|&&e| !scene.ranking(e, false).is_empty());
    let Some(&error) = shared.or_else(alone) else {
        return "No method without bias reached a relative error of 100 % in every repeat: give it more time.".into();
    };
    let ranking = scene.ranking(error, false);
    let (best, time) = ranking[0];
    let name = |m: usize| scene.methods[m].name.as_str();
    let mut text = format!("{} reaches {} in {}", name(best), level(error), seconds(time.value));
    match ranking.get(1) {
        None => text += ", and no other method without bias reaches it",
        Some(&(second, _)) => {
            let sooner = sooner(scene, second, best, error);
            if sooner.is_none_or(|s| s.holds(1.0)) {
                text += &format!(", no sooner than {} as far as this race can tell", name(second));
            } else if let Some(sooner) = sooner {
                text += &format!(", {} sooner than {}", factor(&sooner), name(second));
            }
            let clearly = |&&(m, _): &&(usize, Interval)| {
                m != second && self::sooner(scene, m, best, error).is_some_and(|s| s.low > 1.0)
            };
            let behind: Vec<_> = ranking[2..].iter().filter(clearly).collect();
            if let Some(&&(last, _)) = behind.last()
                && let Some(sooner) = self::sooner(scene, last, best, error)
            {
                text += &format!(" and {} sooner than {}", factor(&sooner), name(last));
            }
        }
    }
    let late = |&m: &usize| scene.methods[m].biased.is_none() && !ranking.iter().any(|r| r.0 == m);
    let late: Vec<&str> = (0..scene.methods.len()).filter(late).map(name).collect();
    if ranking.len() > 1 && !late.is_empty() {
        text += &format!("; {} did not reach it", list(&late));
    }
    text + "."
}

/// "a, b and c".
fn list(names: &[&str]) -> String {
    match names {
        [.., last] if names.len() > 1 => format!("{} and {last}", names[..names.len() - 1].join(", ")),
        _ => names.join(""),
    }
}

/// The ratio of the times of `slow` and `fast`.
pub(super) fn sooner(scene: &SceneData, slow: usize, fast: usize, error: f64) -> Option<Interval> {
    let (slow, fast) = (scene.times_to(slow, error)?, scene.times_to(fast, error)?);
    Some(ratio(&slow, &fast)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::synthetic;

    #[test]
    fn the_answer_names_the_faster() {
        let text = answer(&synthetic(1, &[4.0, 1.0], 0.02, 0.0));
        assert!(text.starts_with("method1/sobol reaches 5 % in "), "{text}");
        assert!(text.contains("sooner than method0/sobol"), "{text}");
    }

    #[test]
    fn no_difference_is_reported_as_none() {
        let text = answer(&synthetic(2, &[1.0, 1.0], 0.05, 0.0));
        assert!(text.contains("as far as this race can tell"), "{text}");
    }

    #[test]
    fn those_that_are_late_are_named() {
        let mut scene = synthetic(1, &[1.0, 1.0, 300.0], 0.02, 0.0);
        scene.rows.iter_mut().filter(|r| r.method == 2).for_each(|r| r.rel_mse *= 100.0);
        assert!(answer(&scene).ends_with("; method2/sobol did not reach it."), "{}", answer(&scene));
        assert_eq!((list(&["a"]), list(&["a", "b", "c"])), ("a".into(), "a, b and c".into()));
    }

    #[test]
    fn biased_methods_never_win() {
        let mut scene = synthetic(1, &[4.0, 1.0], 0.02, 0.0);
        scene.methods[1].biased = Some("on purpose".into());
        assert!(answer(&scene).starts_with("method0/sobol reaches"), "{}", answer(&scene));
        scene.methods[0].biased = Some("too".into());
        assert!(answer(&scene).starts_with("No method without bias"));
    }
}
