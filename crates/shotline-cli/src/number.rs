//! Numbers as people read and write them.

use serde_json::Value;
use shotline::math::Vec3;

/// Nine significant digits without trailing zeros: enough to tell values apart, short enough for a table.
pub fn short(x: f64) -> String {
    if !x.is_finite() || x == 0.0 {
        return (x + 0.0).to_string(); // -0 reads as 0
    }
    let magnitude = x.abs().log10().floor();
    if !(-4.0..9.0).contains(&magnitude) {
        let text = format!("{x:.8e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", trimmed(digits));
    }
    let decimals = (8.0 - magnitude).max(0.0) as usize;
    trimmed(&format!("{x:.decimals$}")).to_string()
}

fn trimmed(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// A point or vector in parentheses.
pub fn short_vector(v: Vec3) -> String {
    format!("({}, {}, {})", short(v.x), short(v.y), short(v.z))
}

/// A count with its thousands apart.
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

/// Bytes in the unit that suits them.
pub fn bytes(n: usize) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let (mut x, mut unit) = (n as f64, 0);
    while x >= 1024.0 && unit + 1 < units.len() {
        (x, unit) = (x / 1024.0, unit + 1);
    }
    if unit == 0 { format!("{n} B") } else { format!("{x:.1} {}", units[unit]) }
}

/// A number in JSON; `null` where it is infinite or NaN, which JSON cannot say.
pub fn json(x: f64) -> Value {
    serde_json::Number::from_f64(x).map_or(Value::Null, Value::Number)
}

/// Three numbers in JSON.
pub fn json_vector(v: Vec3) -> Value {
    Value::Array(vec![json(v.x), json(v.y), json(v.z)])
}

/// Reads `X,Y,Z`.
///
/// # Errors
/// A text that says what is wrong.
pub fn parse_vector(text: &str) -> Result<Vec3, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, z] = parts[..] else {
        return Err(format!("expected three numbers X,Y,Z without spaces, not {}", parts.len()));
    };
    Ok(Vec3::new(parse_finite(x)?, parse_finite(y)?, parse_finite(z)?))
}

fn parse_finite(text: &str) -> Result<f64, String> {
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
            (6.02214076e23, "6.02214076e23"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(x), text);
        }
    }

    #[test]
    fn vectors_are_read() {
        assert_eq!(parse_vector("-1,0,2.5e-3"), Ok(Vec3::new(-1.0, 0.0, 2.5e-3)));
        assert!(parse_vector("1,2").unwrap_err().contains("not 2"));
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
