//! Integrals of formulas: sampling and quadrature agree with the truth where they should, and a
//! warning says where quadrature fails.

mod common;

use std::f64::consts::PI;

use common::{Folder, Ran};
use serde_json::Value;

fn integrate(folder: &Folder, formula: &str, options: &str) -> Ran {
    let words = ["integrate", formula].into_iter().chain(options.split_whitespace());
    Ran::from(folder.command(words).output().unwrap())
}

fn json(formula: &str, options: &str) -> Value {
    let ran = integrate(&Folder::new(), formula, &format!("{options} --json")).succeeded();
    serde_json::from_str(&ran.stdout).unwrap()
}

fn row<'a>(report: &'a Value, method: &str) -> &'a Value {
    report["methods"].as_array().unwrap().iter().find(|row| row["method"].as_str().unwrap().contains(method)).unwrap()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("no {key} in {row}"))
}

/// The three samplers' intervals, at 99.99 %, hold the truth: α = 1e-4 each. `width` is the limit
/// for the widest, which bounds a hidden bias.
#[track_caller]
fn sampling_holds(report: &Value, truth: f64, width: f64) {
    for method in ["independent", "stratified", "Sobol"] {
        let row = row(report, method);
        let (estimate, half) = (number(row, "estimate"), number(row, "half_width"));
        // f32 rounding is not part of the interval.
        assert!((estimate - truth).abs() <= half + 1e-6 * truth.abs(), "{method}: {row}");
        assert!(half > 0.0 && half < width, "{method}: {row}");
    }
}

#[test]
fn the_lectures_example_is_one() {
    let report = json("5*pow(x,4)", "--over 0..1 --exact 1 --confidence 99.99%");
    // σ² = 16/9 (the lecture's "variance: what is it?"): the standard error of 2^20 samples is
    // 0.0013.
    sampling_holds(&report, 1.0, 0.0013 * 6.0);
    assert!((number(row(&report, "independent"), "half_width") / 0.0013 / 4.4 - 1.0).abs() < 0.6, "{report}");
    for rule in ["midpoint", "Simpson", "Gauss"] {
        assert!(number(row(&report, rule), "true_error") < 1e-6, "{report}");
    }
    assert_eq!(report["notes"], serde_json::json!([]));
}

#[test]
fn a_constant_and_ten_dimensions() {
    let report = json("2.5", "--over 1..3 --samples 32");
    for method in report["methods"].as_array().unwrap() {
        assert!((number(method, "estimate") - 5.0).abs() < 1e-6, "{method}");
    }
    let ten = (0..10).map(|i| format!("x{i}")).collect::<Vec<_>>().join("+");
    let report = json(&ten, &format!("--over {} --confidence 99.99%", ["0..2"; 10].join(",")));
    sampling_holds(&report, 10.0 * 1024.0, 20.0);
    assert!((number(row(&report, "Gauss"), "estimate") / 10240.0 - 1.0).abs() < 1e-6);
}

#[test]
fn quadrature_fails_on_an_edge_in_two_dimensions() {
    // A square whose edges fall between the nodes: an error of up to 1/1024 of it whatever the
    // rule's order.
    let report = json("f32(max(x, y) < sqrt(0.5))", "--over 0..1,0..1 --exact 0.5 --confidence 99.99%");
    sampling_holds(&report, 0.5, 0.003);
    let sobol = number(row(&report, "Sobol"), "half_width");
    for rule in ["midpoint", "Simpson", "Gauss"] {
        let error = number(row(&report, rule), "true_error");
        assert!(error > 3.0 * sobol, "{rule}: {error} against {sobol}");
        assert!(report["notes"].to_string().contains(rule), "{report}");
    }
    // Round edges: no rule's order is left, Simpson's is 4 where all is smooth.
    let disc = json("f32(x*x + y*y < 1)", &format!("--over 0..1,0..1 --exact {} --confidence 99.99%", PI / 4.0));
    sampling_holds(&disc, PI / 4.0, 0.003);
    assert!(number(row(&disc, "Simpson"), "true_error") > 1e-7, "{disc}");
}

#[test]
fn quadrature_fails_in_six_dimensions() {
    // A cube whose faces fall between the nodes, of which an axis has only ten.
    let cube = "f32(max(max(max(x, y), max(z, w)), max(x4, x5)) < 0.63)";
    let truth = 0.63f64.powi(6);
    let report = json(cube, &format!("--over {} --exact {truth} --confidence 99.99%", ["0..1"; 6].join(",")));
    sampling_holds(&report, truth, 0.003);
    let best = number(row(&report, "Sobol"), "half_width");
    for rule in ["midpoint", "Simpson", "Gauss"] {
        let error = number(row(&report, rule), "true_error");
        assert!(error > 4.0 * best, "{rule}: {error} against {best}");
    }
    assert_eq!(report["notes"].to_string().matches("quadrature fails").count(), 3, "{report}");
    // An orthant of the 6-ball: π³/6/64. Points that are well spread in pairs of dimensions must
    // not be tied across them.
    let ball = "f32(x*x + y*y + z*z + w*w + x4*x4 + x5*x5 < 1)";
    let report = json(ball, &format!("--over {} --confidence 99.99%", ["0..1"; 6].join(",")));
    sampling_holds(&report, PI.powi(3) / 384.0, 0.002);
}

#[test]
fn the_chart_shows_every_method_and_its_slope() {
    let folder = Folder::new();
    let ran = integrate(&folder, "sin(pi*x)*y*y", "--over 0..1,0..1 --samples 262144 -o c.svg --json").succeeded();
    assert_eq!(folder.files(), ["c.svg"]);
    let svg = std::fs::read_to_string(folder.path("c.svg")).unwrap();
    assert_eq!(svg.matches("<polyline").count(), 6);
    for word in ["sin(pi*x)*y*y", "evaluations", "Sobol", "Gauss-Legendre", "independent"] {
        assert!(svg.contains(word), "{word}");
    }
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    // Least squares over 14 points; a standard error from 32 replicates has a spread of 1/√62 = 13
    // %, so that the slope's standard deviation is 0.13 / (ln 2 · √(Σ(k−k̄)²)) = 0.012: five of
    // them are allowed.
    let slope = |method: &str| {
        let points: Vec<(f64, f64)> = row(&report, method)["convergence"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| (p[0].as_f64().unwrap().ln(), p[1].as_f64().unwrap().ln()))
            .collect();
        assert!(points.len() >= 13, "{points:?}");
        let n = points.len() as f64;
        let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let over: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
        over / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
    };
    assert!((slope("independent") + 0.5).abs() < 0.06, "{}", slope("independent"));
    assert!(slope("Sobol") < -0.9, "{}", slope("Sobol"));
    assert!(slope("stratified") < -0.8, "{}", slope("stratified"));
}

#[test]
fn values_that_are_not_finite_are_counted_and_heavy_tails_reported() {
    let report = json("1/x", "--over 0..1 --samples 65536");
    // Simpson's first node is 0.
    assert_eq!(number(row(&report, "Simpson"), "non_finite"), 1.0);
    let notes = report["notes"].to_string();
    assert!(notes.contains("not finite") && notes.contains("heavy tail"), "{notes}");
    // log of a negative number.
    let report = json("log(x)", "--over -1..1 --samples 3200");
    let lost = number(row(&report, "independent"), "non_finite");
    assert!((1200.0..2000.0).contains(&lost), "{lost}");
    let report = json("exp(x)", "--over 0..1 --samples 65536");
    assert_eq!(report["notes"], serde_json::json!([]));
}

#[test]
fn the_seed_alone_decides() {
    let run = |seed: u32| json("exp(x)", &format!("--over 0..1 --samples 4096 --seed {seed}"));
    let estimate = |report: &Value, method: &str| number(row(report, method), "estimate");
    let (a, b, c) = (run(1), run(1), run(2));
    for method in ["independent", "stratified", "Sobol"] {
        assert_eq!(estimate(&a, method), estimate(&b, method));
        assert_ne!(estimate(&a, method), estimate(&c, method));
    }
}

#[test]
fn bad_formulas_are_reported_with_the_column() {
    let folder = Folder::new();
    for (formula, words) in [
        ("5*powr(x,4)", ["column 3", "powr"]),
        ("x + y", ["column 5", "variable number 2"]),
        ("x; } @compute fn f() {", ["column 2", "only one expression"]),
        ("x > 0.5", ["column 1", "f32("]),
        ("(x", ["column 1", "partner"]),
    ] {
        integrate(&folder, formula, "--over 0..1").failed_with(&words);
    }
    assert!(folder.files().is_empty());
    for options in ["", "--over 1..0", "--over 0..1 --samples 3", "--over 0..1 -o chart.png"] {
        assert_eq!(integrate(&folder, "x", options).code, Some(2), "{options}");
    }
}

#[test]
fn the_table_is_readable() {
    let text = integrate(&Folder::new(), "5*pow(x,4)", "--over 0..1 --samples 4096").succeeded().stdout;
    for word in
        ["Monte Carlo, independent", "midpoint", "Gauss-Legendre", "95 % confidence", "f32", "hint, not a bound"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
}
