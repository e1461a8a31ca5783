//! Words, strings and numbers of JSON, with its strict grammar and helpful messages.

use std::borrow::Cow;
use std::ops::Range;

use super::value_tree::Content;
use crate::diagnostic::RawDiagnostic;

/// The value of a bare word.
pub(super) fn word(text: &str, range: Range<usize>) -> Result<Content<'static>, RawDiagnostic> {
    let written = &text[range.clone()];
    match written {
        "null" => Ok(Content::Null),
        "true" => Ok(Content::Bool(true)),
        "false" => Ok(Content::Bool(false)),
        "NaN" | "nan" | "Infinity" | "inf" => {
            Err(RawDiagnostic::text(range, format!("{written} is not a number"))
                .help("numbers are finite; for something without end use a half-space or a quadric"))
        }
        _ => Err(RawDiagnostic::text(range, format!("'{written}' stands without quotes"))
            .help(format!("write \"{written}\", or true, false or null"))),
    }
}

/// The number that a run of characters denotes.
pub(super) fn number(text: &str, range: Range<usize>) -> Result<f64, RawDiagnostic> {
    let written = &text[range.clone()];
    if let Some(why) = misspelled(written) {
        return Err(RawDiagnostic::text(range, format!("'{}' is not a number: {why}", cut(written))));
    }
    match written.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(RawDiagnostic::text(range, format!("{} is too large for a float64", cut(written)))
            .help("the largest float64 is about 1.8e308")),
    }
}

fn cut(written: &str) -> &str {
    written.get(..40).unwrap_or(written)
}

/// Why a number violates the grammar `-?(0|[1-9][0-9]*)(.[0-9]+)?([eE][+-]?[0-9]+)?`.
fn misspelled(written: &str) -> Option<&'static str> {
    let mut rest = written.strip_prefix('-').unwrap_or(written);
    let digits = |rest: &mut &str| {
        let n = rest.bytes().take_while(u8::is_ascii_digit).count();
        *rest = &rest[n..];
        n
    };
    if rest.starts_with('+') {
        return Some("a leading + is not allowed");
    }
    if rest.starts_with("Infinity") || rest.starts_with("inf") {
        return Some("it must be finite");
    }
    if rest.starts_with("0x") || rest.starts_with("0X") {
        return Some("only decimal numbers are allowed");
    }
    if rest.len() > 1 && rest.starts_with('0') && rest.as_bytes()[1].is_ascii_digit() {
        return Some("a leading 0 is not allowed");
    }
    if digits(&mut rest) == 0 {
        return Some("a digit must come first");
    }
    if let Some(fraction) = rest.strip_prefix('.') {
        rest = fraction;
        if digits(&mut rest) == 0 {
            return Some("a digit must follow the point");
        }
    }
    if let Some(exponent) = rest.strip_prefix(['e', 'E']) {
        rest = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
        if digits(&mut rest) == 0 {
            return Some("the exponent has no digits");
        }
    }
    if rest.is_empty() { None } else { Some("something follows the digits") }
}

/// The text between two quotes, with its escapes resolved. `range` excludes the quotes. Errors go to
/// `report`; invalid escapes are replaced by U+FFFD.
pub(super) fn unescape<'t>(
    text: &'t str,
    range: Range<usize>,
    report: &mut dyn FnMut(RawDiagnostic),
) -> Cow<'t, str> {
    let body = &text[range.clone()];
    if let Some(at) = body.bytes().position(|byte| byte < b' ') {
        let at = range.start + at;
        report(
            RawDiagnostic::text(at..at + 1, "a control character in a string")
                .help("write it as \\t or \\u00XX"),
        );
    }
    if !body.contains('\\') {
        return Cow::Borrowed(body);
    }
    let mut out = String::with_capacity(body.len());
    let mut at = 0;
    while let Some(found) = body[at..].find('\\') {
        out.push_str(&body[at..at + found]);
        at += found;
        match escape(&body[at..]) {
            Ok((character, length)) => {
                out.push(character);
                at += length;
            }
            Err((length, why)) => {
                out.push('\u{FFFD}');
                report(RawDiagnostic::text(range.start + at..range.start + at + length, why));
                at += length;
            }
        }
    }
    out.push_str(&body[at..]);
    Cow::Owned(out)
}

/// The character and the length of the escape at the start of a text; or the length to skip and the error.
fn escape(text: &str) -> Result<(char, usize), (usize, &'static str)> {
    let Some(letter) = text.chars().nth(1) else {
        return Err((1, "the escape has no end"));
    };
    let simple = match letter {
        '"' | '\\' | '/' => letter,
        'b' => '\u{8}',
        'f' => '\u{C}',
        'n' => '\n',
        'r' => '\r',
        't' => '\t',
        'u' => return unicode_escape(text),
        _ => return Err((1 + letter.len_utf8(), "there is no such escape")),
    };
    Ok((simple, 2))
}

fn unicode_escape(text: &str) -> Result<(char, usize), (usize, &'static str)> {
    let unit = |at: usize| {
        let escape = text.get(at..at + 6)?;
        let digits = escape.strip_prefix("\\u")?;
        let hex = digits.bytes().all(|b| b.is_ascii_hexdigit());
        hex.then(|| u32::from_str_radix(digits, 16).ok()).flatten()
    };
    let Some(first) = unit(0) else { return Err((2, "\\u takes four hexadecimal digits")) };
    if let Some(character) = char::from_u32(first) {
        return Ok((character, 6));
    }
    match (first, unit(6)) {
        (0xD800..0xDC00, Some(second @ 0xDC00..0xE000)) => {
            let code = 0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00);
            Ok((char::from_u32(code).unwrap_or('\u{FFFD}'), 12))
        }
        _ => Err((6, "half of a surrogate pair is not a character")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_follow_the_grammar() {
        for good in ["0", "-0.0", "1", "10.25", "1e5", "1E-5", "-1.5e+300", "5e-324", "1e-400"] {
            assert_eq!(
                number(good, 0..good.len()).map(f64::to_bits),
                Ok(good.parse::<f64>().unwrap().to_bits())
            );
        }
        for bad in [
            "",
            "-",
            "+1",
            ".5",
            "5.",
            "01",
            "0x10",
            "1e",
            "1e+",
            "1.e5",
            "-Infinity",
            "1_000",
            "1e400",
            "--1",
        ] {
            assert!(number(bad, 0..bad.len()).is_err(), "{bad}");
        }
    }

    #[test]
    fn escapes_are_resolved_and_lone_surrogates_refused() {
        let mut diagnostics = Vec::new();
        let text = r#"a\n\u00e9\ud83d\ude00\/"#;
        assert_eq!(unescape(text, 0..text.len(), &mut |f| diagnostics.push(f)), "a\né😀/");
        assert!(diagnostics.is_empty());
        for bad in [r"\ud800", r"\ud800\u0041", r"\udc00x", r"\u12", r"\q", r"\u+123", r"\é"] {
            diagnostics.clear();
            unescape(bad, 0..bad.len(), &mut |f| diagnostics.push(f));
            assert!(!diagnostics.is_empty(), "{bad}");
        }
    }
}
