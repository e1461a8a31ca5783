//! "Did you mean": the nearest known name.

/// The known name nearest to the given one, if it is near enough to be a typing error.
pub fn nearest_name<'n>(written: &str, known: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    // A name of more than 64 characters is not a typing error, and the distance takes quadratic time.
    let letters: Vec<char> = written.chars().take(65).flat_map(char::to_lowercase).collect();
    if letters.len() > 64 {
        return None;
    }
    let allowed = 1 + letters.len() / 4;
    known
        .into_iter()
        .filter(|name| name.chars().count().abs_diff(letters.len()) <= allowed)
        .map(|name| (distance(&letters, &name.to_lowercase().chars().collect::<Vec<_>>()), name))
        .filter(|(d, _)| *d <= allowed)
        .min_by_key(|(d, _)| *d)
        .map(|(_, name)| name)
}

/// "did you mean 'x'?", or else the list of known names.
pub(crate) fn hint(written: &str, known: &[&str]) -> String {
    match nearest_name(written, known.iter().copied()) {
        Some(name) => format!("did you mean '{name}'?"),
        None if known.is_empty() => "there are none".into(),
        None if known.len() > 24 => format!("there are {} to choose from", known.len()),
        None => format!("there is {}", known.join(", ")),
    }
}

/// Edit distance in which a transposition of neighbours counts once (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let substitute = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substitute.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_are_recognised_and_other_names_are_not() {
        let known = ["radius", "sphere", "z0", "z1", "intersection"];
        assert_eq!(nearest_name("raduis", known), Some("radius"));
        assert_eq!(nearest_name("Radius", known), Some("radius"));
        assert_eq!(nearest_name("intersecton", known), Some("intersection"));
        assert_eq!(nearest_name("colour", known), None);
        assert_eq!(nearest_name(&"x".repeat(5000), known), None);
    }
}
