//! Numbers as text and JSON.

use serde_json::Value;
use shotline::aabb::Aabb;
use shotline::math::Vec3;

/// Nine significant digits without trailing zeros: enough to distinguish values, short enough for a table.
pub fn short(x: f64) -> String {
    significant(x, 9)
}

/// So many significant digits, without trailing zeros.
pub fn significant(x: f64, digits: usize) -> String {
    if !x.is_finite() || x == 0.0 {
        return (x + 0.0).to_string(); // -0 reads as 0
    }
    let last = digits - 1;
    let scientific = format!("{x:.last$e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    match exponent.parse::<i32>() {
        Ok(exponent) if (-4..digits as i32).contains(&exponent) => {
            let decimals = (last as i32 - exponent) as usize;
            trimmed(&format!("{x:.decimals$}")).to_string()
        }
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

fn trimmed(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// A value with its standard error, both rounded to two significant digits of the error, but at most to whole numbers;
/// the value alone if the error is 0.
pub fn uncertain(x: f64, error: f64) -> String {
    if error == 0.0 {
        return short(x);
    }
    let decimals = 1.0 - error.abs().log10().floor();
    if x.abs().max(error) < 1e12 && decimals <= 12.0 {
        let decimals = decimals.max(0.0) as usize;
        return format!("{x:.decimals$} ± {error:.decimals$}");
    }
    format!("{} ± {}", short(x), significant(error, 2))
}

/// A point or vector in parentheses.
pub fn short_vector(v: Vec3) -> String {
    format!("({}, {}, {})", short(v.x), short(v.y), short(v.z))
}

/// The corners of a box; coordinates that are only padding for rounding are shown as 0.
pub fn short_bounds(bounds: &Aabb) -> String {
    let ends = bounds.min.to_array().into_iter().chain(bounds.max.to_array());
    let size = ends.filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
    let plain = |v: Vec3| v.to_array().map(|x| if x.abs() < 1e-12 * size { 0.0 } else { x });
    format!("{} to {}", short_vector(plain(bounds.min).into()), short_vector(plain(bounds.max).into()))
}

/// A unit vector in parentheses: six digits identify a direction.
pub fn short_normal(v: Vec3) -> String {
    let digits = |x: f64| significant((x * 1e6).round() / 1e6, 6);
    format!("({}, {}, {})", digits(v.x), digits(v.y), digits(v.z))
}

/// A count with thousands separators.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A count and its noun: `1 edge`, `2 edges`.
pub fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(n), if n == 1 { one } else { many })
}

/// A number of bytes in a suitable unit.
pub fn bytes(n: usize) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let (mut x, mut unit) = (n as f64, 0);
    while x >= 1024.0 && unit + 1 < units.len() {
        (x, unit) = (x / 1024.0, unit + 1);
    }
    if unit == 0 { format!("{n} B") } else { format!("{x:.1} {}", units[unit]) }
}

/// A number in JSON; `null` where it is infinite or NaN, which JSON cannot express.
pub fn json(x: f64) -> Value {
    serde_json::Number::from_f64(x).map_or(Value::Null, Value::Number)
}

/// Three numbers in JSON.
pub fn json_vector(v: Vec3) -> Value {
    Value::Array(vec![json(v.x), json(v.y), json(v.z)])
}

/// Parses `X,Y,Z`, or the three numbers with spaces between them.
///
/// # Errors
/// A message that says what is wrong.
pub fn parse_vector(text: &str) -> Result<Vec3, String> {
    let fields: Vec<&str> =
        if text.contains(',') { text.split(',').collect() } else { text.split_whitespace().collect() };
    let [x, y, z] = fields[..] else {
        return Err(format!("expected three numbers X,Y,Z, not {}", fields.len()));
    };
    Ok(Vec3::new(parse_finite(x)?, parse_finite(y)?, parse_finite(z)?))
}

/// Parses a finite number.
///
/// # Errors
/// A message that says what is wrong.
pub fn parse_finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("'{text}' is not finite")),
        Err(_) => Err(format!("'{text}' is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_keep_nine_digits() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (1.0 / 3.0, "0.333333333"),
            (123456789.25, "123456789"),
            (1e-7, "1e-7"),
            (999999999.7, "1e9"),
            (6.02214076e23, "6.02214076e23"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(x), text);
        }
    }

    #[test]
    fn values_are_rounded_to_the_digits_of_their_error() {
        for (x, error, text) in [
            (523.598776, 0.0123, "523.599 ± 0.012"),
            (-0.00001234567, 2.5e-9, "-0.0000123457 ± 0.0000000025"),
            (1234567.0, 890.0, "1234567 ± 890"),
            (6.02e23, 1e20, "6.02e23 ± 1e20"),
            (0.5, f64::NAN, "0.5 ± NaN"),
            (1.0 / 3.0, 0.0, "0.333333333"),
        ] {
            assert_eq!(uncertain(x, error), text);
        }
    }

    #[test]
    fn vectors_are_parsed() {
        assert_eq!(parse_vector("-1,0,2.5e-3"), Ok(Vec3::new(-1.0, 0.0, 2.5e-3)));
        assert_eq!(parse_vector(" 1  2 3"), Ok(Vec3::new(1.0, 2.0, 3.0)));
        assert_eq!(parse_vector("1, 2, 3"), Ok(Vec3::new(1.0, 2.0, 3.0)));
        assert!(parse_vector("1,2").unwrap_err().contains("not 2"));
        assert!(parse_vector("1 2").unwrap_err().contains("not 2"));
        assert!(parse_vector("1,x,2").unwrap_err().contains("'x'"));
        assert!(parse_vector("1,nan,2").unwrap_err().contains("not finite"));
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(1234567), "1,234,567");
        assert_eq!(counted(1, "edge", "edges"), "1 edge");
        assert_eq!(bytes(1536), "1.5 KiB");
    }
}
