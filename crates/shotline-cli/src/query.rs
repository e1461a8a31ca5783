//! The queries of many rays.

use clap::ValueEnum;
use shotline::query::batch::By;
use shotline::query::{Overlaps, QueryError, Scope};
use shotline::ray::Span;

use crate::failure::Failure;
use crate::flags::SurfacesOnly;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Query {
    /// The first crossing
    Closest,
    /// Whether there is any crossing
    Any,
    /// The number of crossings
    Count,
    /// Every crossing
    Crossings,
    /// The segments inside objects
    Segments,
    /// The length of each ray in each material or object
    Thickness,
}

impl Query {
    /// The name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// The scope of the query.
    ///
    /// # Errors
    /// If only surfaces are wanted, but the query is for segments.
    pub fn scope(self, span: Span, only: SurfacesOnly) -> Result<Scope, Failure> {
        if only.surfaces_only && matches!(self, Query::Segments | Query::Thickness) {
            let why = "segments are those of the entire ray, also where it begins or ends inside";
            let help = "use --query closest, any, count or crossings, or leave the flag out";
            let name = self.name();
            return Err(Failure::new(format!("--surfaces-only is not for {name}: {why}\nhelp: {help}")));
        }
        Ok(Scope { span, kinds: only.kinds() })
    }
}

/// What thickness has columns for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ThicknessBy {
    /// A column for each material, and a last one for objects without a material
    Material,
    /// A column for each object
    Object,
}

impl From<ThicknessBy> for By {
    fn from(by: ThicknessBy) -> By {
        match by {
            ThicknessBy::Material => By::Material,
            ThicknessBy::Object => By::Object,
        }
    }
}

/// What to do where objects of equal priority overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OverlapPolicy {
    /// End with an error that names both objects and the interval
    Error,
    /// The object that is placed later owns the overlap; overlaps are counted
    Priority,
    /// Every object keeps its segment
    All,
}

impl From<OverlapPolicy> for Overlaps {
    fn from(policy: OverlapPolicy) -> Overlaps {
        match policy {
            OverlapPolicy::Error => Overlaps::Error,
            OverlapPolicy::Priority => Overlaps::Priority,
            OverlapPolicy::All => Overlaps::All,
        }
    }
}

/// How to correct a query that returns an error.
pub fn help(error: &QueryError) -> &'static str {
    match error {
        QueryError::NotASolid { .. } => {
            "close the mesh (`shotline check` lists its defects) or use --query crossings"
        }
        QueryError::Overlap { .. } => {
            "give one of them a higher \"priority\", or use --overlaps priority or all"
        }
        QueryError::TooMany { .. } => {
            "shorten the ray with --t-min and --t-max, or use --query closest or count"
        }
        QueryError::TooLong { .. } => {
            "shorten the ray with --t-min and --t-max, or nest fewer parts in each other"
        }
        QueryError::OutOfMemory => "cast fewer rays at a time, or use --query closest or count",
        QueryError::Cancelled => "cast again",
    }
}
