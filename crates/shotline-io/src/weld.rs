//! The note of what welding did to a mesh as it was read.

use shotline::solid::mesh::{Weld, Welded};

use crate::note::{Effect, Note};

/// A length with four significant digits.
fn short(length: f64) -> String {
    plain(format!("{length:.3e}").parse().unwrap_or(length))
}

/// A length with all its digits, and an exponent where it is very small or large.
fn plain(length: f64) -> String {
    format!("{length:?}").trim_end_matches(".0").to_string()
}

/// What welding did, as a note.
pub fn weld_note(weld: Weld, welded: &Welded) -> Note {
    let many =
        |count: usize, one: &str, many: &str| format!("{count} {}", if count == 1 { one } else { many });
    let Some(distance) = welded.distance else {
        return match welded.unclear {
            0 => {
                let text = "nothing to weld: no vertices are within rounding of each other but not in one place; to merge \
                            vertices that are farther apart give a distance instead of auto";
                Note::new("welded", Effect::Kept, 1, text)
            }
            count => {
                let text = format!(
                    "nothing was welded: {} within rounding of another, but the distances between vertices show no clear \
                     gap; give a distance instead of auto",
                    many(count, "vertex is", "vertices are")
                );
                Note::new("weld_no_gap", Effect::Kept, count, text)
            }
        };
    };
    let within = match (weld, welded.apart) {
        (Weld::Auto, Some(apart)) => {
            format!("within {}, all others being {} or more apart", short(distance), short(apart))
        }
        _ => format!("within {}", plain(distance)),
    };
    let mut parts = Vec::new();
    match welded.merged {
        0 if distance > 0.0 => {
            parts.push(format!("no vertices were merged: no two that are in different places lie {within}"));
        }
        0 if welded.repeated == 0 => parts.push("no vertices were merged: no two are in one place".into()),
        0 => {}
        count => {
            let vertices = many(count, "vertex was merged with another", "vertices were merged with others");
            parts.push(format!("{vertices} {within}, moved by {} at most", short(welded.farthest)));
        }
    }
    if welded.repeated > 0 {
        let vertices =
            many(welded.repeated, "vertex in the place of another", "vertices in the places of others");
        parts.push(format!("{vertices} became one with these"));
    }
    if welded.collapsed > 0 {
        let faces = many(welded.collapsed, "face collapsed and was", "faces collapsed and were");
        parts.push(format!("{faces} dropped"));
    }
    let text = parts.join("; ");
    let changed = welded.merged > 0 || welded.collapsed > 0;
    Note::new("welded", if changed { Effect::Changed } else { Effect::Kept }, welded.merged.max(1), text)
}
