//! The report as a table.

use shotline::query::{ConflictKind, HitKind};

use super::{CrossingRow, ShootReport, length};
use crate::number::{counted, short, short_normal, short_vector};
use crate::table::{Align, Table};

impl ShootReport {
    /// The report as text: the ray, one line per crossing, totals.
    pub fn to_text(&self) -> String {
        let mut out = self.heading();
        if self.crossings.is_empty() {
            out += "\nmiss: the ray crosses nothing\n";
            return out;
        }
        out += "\n";
        out += &self.table().text();
        out += "\n";
        out += &self.footer();
        out
    }

    fn unit(&self) -> String {
        self.units.map_or_else(String::new, |u| format!(" {u}"))
    }

    fn heading(&self) -> String {
        let (o, d) = (self.ray.origin(), self.ray.direction());
        format!(
            "ray from {} along {}, t from {} to {}, one t = {}{}\n",
            short_vector(o),
            short_vector(d),
            short(self.span.t_min()),
            short(self.span.t_max()),
            short(length(d)),
            self.unit(),
        )
    }

    fn table(&self) -> Table {
        let column = |name: &str, align| (name.to_string(), align);
        let measure = |name: &str| match self.units {
            Some(unit) => (format!("{name} [{unit}]"), Align::Right),
            None => (name.to_string(), Align::Right),
        };
        let mut table = Table::new(vec![
            column("#", Align::Right),
            column("t", Align::Right),
            measure("distance"),
            column("x", Align::Right),
            column("y", Align::Right),
            column("z", Align::Right),
            column("", Align::Left),
            column("object", Align::Left),
            column("surface", Align::Left),
            column("material", Align::Left),
            column("path", Align::Left),
            column("normal", Align::Left),
            column("obliquity", Align::Right),
            measure("thickness"),
        ]);
        for (i, crossing) in self.crossings.iter().enumerate() {
            table.row(cells(i + 1, crossing));
        }
        table
    }

    fn footer(&self) -> String {
        let mut out = String::new();
        let n = self.crossings.len() as u64;
        out += &format!("{}\n", counted(n, "crossing", "crossings"));
        let width = self.totals.iter().map(|t| material(&t.material).chars().count()).max().unwrap_or(0);
        for total in &self.totals {
            out += &format!(
                "  {:width$}  {}{} in {}\n",
                material(&total.material),
                short(total.length),
                self.unit(),
                counted(total.segments as u64, "segment", "segments"),
            );
        }
        if self.totals.len() > 1 {
            let sum: f64 = self.totals.iter().map(|t| t.length).sum();
            out += &format!("  {:width$}  {}{}\n", "all", short(sum), self.unit());
        }
        for o in &self.overlaps {
            let (from, to) = (short(o.t_in), short(o.t_out));
            out += &match o.kind {
                ConflictKind::Overlap => format!(
                    "overlap: '{}' and '{}' of equal priority from t = {from} to t = {to}; the one placed later owns it\n",
                    o.first, o.second,
                ),
                ConflictKind::Protrusion => format!(
                    "protrusion: '{}' sticks out of '{}' from t = {from} to t = {to}, where it does not count\n",
                    o.first, o.second,
                ),
            };
        }
        if let Some(no_thickness) = &self.no_thickness {
            out += &format!("no thickness: {no_thickness}\n");
        }
        out
    }
}

fn cells(number: usize, row: &CrossingRow) -> Vec<String> {
    let dash = || "-".to_string();
    let coordinate = |i: usize| row.point.map_or_else(dash, |p| short(p[i]));
    let event = match (row.hit.entering, row.hit.kind) {
        (true, HitKind::Surface) => "in",
        (false, HitKind::Surface) => "out",
        (_, HitKind::Start) => "in (start)",
        (_, HitKind::End) => "out (end)",
    };
    vec![
        number.to_string(),
        short(row.hit.t),
        short(row.distance),
        coordinate(0),
        coordinate(1),
        coordinate(2),
        event.to_string(),
        row.object.clone(),
        row.surface.clone().unwrap_or_else(dash),
        material(&row.material).to_string(),
        row.path.clone(),
        row.obliquity.map_or_else(dash, |_| short_normal(row.hit.normal)),
        row.obliquity.map_or_else(dash, |a| format!("{a:.2}")),
        row.thickness.map_or_else(dash, short),
    ]
}

fn material(name: &Option<String>) -> &str {
    name.as_deref().unwrap_or("-")
}
