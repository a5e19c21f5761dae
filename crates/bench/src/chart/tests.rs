//! Charts contain the data and the names of the methods.

use super::*;
use crate::testing::synthetic;

#[test]
fn every_chart_is_drawn_and_names_the_methods() {
    let mut scene = synthetic(1, &[1.0, 2.0], 0.02, 0.0);
    scene.methods[1].biased = Some("on purpose".into());
    scene.methods[0].name = "a<b>&c".into();
    let peer = Peer {
        scene: "synthetic".into(),
        renderer: "other".into(),
        seconds: 1.0,
        rel_mse: 0.01,
        spp: None,
        pixels: None,
    };
    let charts = [
        convergence(&scene, std::slice::from_ref(&peer), false),
        convergence(&scene, &[], true),
        front(&scene, &[peer]),
        calibration(&scene),
        bias(&scene),
        stages(&scene),
    ];
    for chart in charts.map(Result::unwrap) {
        for svg in [&chart.wide, &chart.narrow] {
            assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{}", chart.name);
            assert!(svg.contains("a&lt;b&gt;&amp;c"), "{}", chart.name);
            // It can be parsed, and is not blank.
            assert!(png(chart.name, svg).unwrap().len() > 5_000, "{}", chart.name);
        }
        assert_eq!(chart.wide.contains("(biased)"), !["front", "stages"].contains(&chart.name), "{}", chart.name);
    }
}

#[test]
fn charts_of_nothing_are_drawn() {
    let mut scene = synthetic(1, &[1.0], 0.02, 0.0);
    scene.rows.clear();
    for chart in
        [convergence(&scene, &[], false), front(&scene, &[]), calibration(&scene), bias(&scene), stages(&scene)]
    {
        png("chart", &chart.unwrap().wide).unwrap();
    }
}

#[test]
fn marks_are_where_the_data_are() {
    // Slope −½ over decades: each step of the samples by 4 moves the mark by one equal step in both
    // directions.
    let scene = synthetic(1, &[1.0], 0.0, 0.0);
    let svg = convergence(&scene, &[], true).unwrap().wide;
    let number = |text: &str, name: &str| -> f64 {
        let from = text.find(name).unwrap() + name.len() + 2;
        text[from..].split('"').next().unwrap().parse().unwrap()
    };
    let marks: Vec<(f64, f64)> =
        svg.split("<circle").skip(1).map(|mark| (number(mark, "cx"), number(mark, "cy"))).collect();
    let curve = scene.curve(0);
    // Each mark is a disc and its rim; the last is that of the legend.
    let marks: Vec<_> = marks.into_iter().step_by(2).collect();
    assert_eq!(marks.len(), curve.len() + 1);
    let steps: Vec<(f64, f64)> = marks[..curve.len()].windows(2).map(|m| (m[1].0 - m[0].0, m[1].1 - m[0].1)).collect();
    for step in &steps {
        assert!((step.0 - steps[0].0).abs() <= 1.5 && (step.1 - steps[0].1).abs() <= 1.5, "{steps:?}");
        assert!(step.0 > 10.0 && step.1 > 5.0);
    }
}
