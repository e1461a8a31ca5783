//! What is asked of many rays.

use clap::ValueEnum;
use shotline::query::batch::By;
use shotline::query::{Overlaps, QueryError, Scope};
use shotline::ray::Span;

use crate::args::SurfacesOnly;
use crate::failure::Failure;

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
    /// The stretches inside objects
    Segments,
    /// How far each ray goes through each material or object
    Thickness,
}

impl Query {
    /// As on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// What is looked at, if the query can be asked so.
    ///
    /// # Errors
    /// If only surfaces are looked for, but stretches are asked for.
    pub fn scope(self, span: Span, only: SurfacesOnly) -> Result<Scope, Failure> {
        if only.surfaces_only && matches!(self, Query::Segments | Query::Thickness) {
            let why = "the stretches inside are those of the whole ray, also where it begins or ends inside";
            let help = "ask for closest, any, count or crossings, or leave the flag out";
            let name = self.name();
            return Err(Failure::new(format!("--surfaces-only is not for {name}: {why}\nhelp: {help}")));
        }
        Ok(Scope { span, kinds: only.kinds() })
    }
}

/// What thickness is counted by.
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
    /// Refuse, naming both objects and the place
    Error,
    /// The later object owns the overlap; overlaps are counted
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

/// What to do about a query without an answer.
pub fn help(error: &QueryError) -> &'static str {
    match error {
        QueryError::NotASolid { .. } => {
            "close the mesh (`shotline check` lists its defects) or ask for crossings"
        }
        QueryError::Overlap { .. } => {
            "give one of them a higher \"priority\", or choose --overlaps priority or all"
        }
        QueryError::TooMany { .. } => {
            "take a part of the ray with --t-min and --t-max, or ask for closest or count"
        }
        QueryError::TooLong { .. } => {
            "take a part of the ray with --t-min and --t-max, or place fewer parts in one another"
        }
        QueryError::OutOfMemory => "cast fewer rays at a time, or ask for closest or count",
        QueryError::Cancelled => "cast again",
    }
}
