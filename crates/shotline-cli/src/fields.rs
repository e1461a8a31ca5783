//! The columns of a result that are written.

use clap::Args;
use shotline::query::batch::Fields;

use crate::failure::Failure;
use crate::query::Query;

/// Which columns are needed.
#[derive(Args, Debug, Clone)]
pub struct FieldsFlag {
    /// Make only these columns, and `t`, which is always there; for `closest` and `crossings`. The others cost nothing
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    fields: Option<Vec<String>>,
}

impl FieldsFlag {
    /// The columns that the result of a query needs.
    ///
    /// # Errors
    /// If the query has no such column.
    pub fn of(&self, query: Query) -> Result<Fields, Failure> {
        let Some(fields) = &self.fields else { return Ok(Fields::ALL) };
        let (always, known): (&[&str], _) = match query {
            Query::Closest => (&["t"], Fields::OF_CLOSEST),
            Query::Crossings => (&["ray_splits", "t"], Fields::OF_CROSSINGS),
            _ => {
                let why = format!("--fields is for --query closest and crossings, not for {}", query.name());
                return Err(Failure::new(format!("{why}\nhelp: leave the flag out")));
            }
        };
        let names: Vec<&str> = always.iter().copied().chain(known.names()).collect();
        let mut wanted = Fields::NONE;
        for name in fields {
            if !names.contains(&name.as_str()) {
                let why = format!("--query {} has no field '{name}'", query.name());
                return Err(Failure::new(format!("{why}\nhelp: the fields are {}", names.join(", "))));
            }
            wanted = Fields::named(name).map_or(wanted, |field| wanted | field);
        }
        Ok(wanted)
    }
}
