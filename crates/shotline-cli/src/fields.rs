//! The columns of a result that are written.

use clap::Args;
use shotline::query::batch;

use crate::failure::Failure;
use crate::query::Query;

/// Which columns are needed.
#[derive(Args, Debug, Clone)]
pub struct Fields {
    /// Make only these columns, and `t`, which is always there; for `closest` and `crossings`. The others cost nothing
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    fields: Option<Vec<String>>,
}

const OF_CLOSEST: &[&str] = &["t", "t_err", "normal", "object", "surface", "primitive", "path", "entering"];
const OF_CROSSINGS: &[&str] =
    &["ray_splits", "t", "t_err", "normal", "entering", "object", "surface", "primitive", "path", "kind"];

impl Fields {
    /// The columns that the result of a query needs.
    ///
    /// # Errors
    /// If the query has no such column.
    pub fn columns(&self, query: Query) -> Result<batch::Columns, Failure> {
        let Some(fields) = &self.fields else { return Ok(batch::Columns::ALL) };
        let known = match query {
            Query::Closest => OF_CLOSEST,
            Query::Crossings => OF_CROSSINGS,
            _ => {
                let why = format!("--fields is for --query closest and crossings, not for {}", query.name());
                return Err(Failure::new(format!("{why}\nhelp: leave the flag out")));
            }
        };
        let mut columns = batch::Columns::NONE;
        for name in fields {
            if !known.contains(&name.as_str()) {
                let why = format!("--query {} has no field '{name}'", query.name());
                return Err(Failure::new(format!("{why}\nhelp: the fields are {}", known.join(", "))));
            }
            columns = batch::Columns::named(name).map_or(columns, |column| columns | column);
        }
        Ok(columns)
    }
}
