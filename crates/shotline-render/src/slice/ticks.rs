//! The ticks of an axis, at round numbers.

/// A tick: its value and its label.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub label: String,
}

/// The ticks in a range: at multiples of 1, 2 or 5 times a power of ten, at most `most` of them where `most` is at least 2.
pub fn ticks(from: f64, to: f64, most: usize) -> Vec<Tick> {
    let rough = (to - from) / most.max(2) as f64;
    let power = rough.log10().floor();
    let scale = 10f64.powf(power);
    let step =
        [1.0, 2.0, 5.0, 10.0].into_iter().map(|x| x * scale).find(|step| *step >= rough * (1.0 - 1e-9));
    let step = step.unwrap_or(rough);
    let (first, last) = ((from / step).ceil(), (to / step).floor());
    // Beyond 2^53 numbers have no room for ticks.
    let is_countable = first.abs().max(last.abs()) < 9e15 && step > 0.0;
    if !is_countable {
        return Vec::new();
    }
    let count = (last - first) as usize + 1;
    let values: Vec<f64> = (0..count).map(|i| (first + i as f64) * step + 0.0).collect();
    let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    let largest = from.abs().max(to.abs());
    let label = |x: f64| {
        if decimals > 6 || largest >= 1e7 {
            let digits = ((largest.log10().floor() - step.log10().floor()).max(0.0) as usize).min(15);
            return if x == 0.0 { "0".into() } else { minus(&format!("{x:.digits$e}")) };
        }
        minus(&format!("{x:.decimals$}"))
    };
    values.into_iter().map(|value| Tick { value, label: label(value) }).collect()
}

/// A number with the sign that is as wide as a digit.
fn minus(number: &str) -> String {
    number.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(from: f64, to: f64) -> Vec<String> {
        ticks(from, to, 6).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(-3.4, 3.4), ["\u{2212}2", "0", "2"]);
        assert_eq!(labels(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(99.5, 102.0), ["99.5", "100.0", "100.5", "101.0", "101.5", "102.0"]);
        assert_eq!(labels(0.0, 6e-9).last().map(String::as_str), Some("6e\u{2212}9"));
        assert_eq!(labels(0.0, 3e8)[1], "5.0e7");
    }

    #[test]
    fn there_are_never_too_many() {
        for (from, to) in
            [(-1e-300, 1e-300), (1e15, 1e15 + 4.0), (-1e300, 1e300), (0.1, 0.7), (5.0, 5.0 + 1e-9)]
        {
            assert!(ticks(from, to, 6).len() <= 8, "{from} {to}");
        }
    }
}
