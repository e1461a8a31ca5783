//! Which columns of a result are requested.

/// A set of columns of [`ClosestRows`](super::ClosestRows) or [`CrossingRows`](super::CrossingRows). A column that is not
/// requested stays empty; `t` and the splits are always there.
///
/// ```
/// use shotline::query::batch::Fields;
/// let fields = Fields::NORMAL | Fields::PRIMITIVE;
/// assert!(fields.contains(Fields::NORMAL) && !fields.contains(Fields::PATH));
/// assert_eq!(Fields::named("t_err"), Some(Fields::T_ERR));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fields(u16);

/// Declares the columns, each with its name and a bit of its own.
macro_rules! fields {
    ($($constant:ident $name:literal $bit:literal),* $(,)?) => {
        impl Fields {
            $(
                #[doc = concat!("The column `", $name, "`.")]
                pub const $constant: Fields = Fields(1 << $bit);
            )*

            /// The columns that can be left out, with their names.
            const NAMED: &[(&str, Fields)] = &[$(($name, Fields::$constant)),*];
        }
    };
}

fields! {
    NORMAL "normal" 0,
    OBJECT "object" 1,
    SURFACE "surface" 2,
    PRIMITIVE "primitive" 3,
    PATH "path" 4,
    ENTERING "entering" 5,
    T_ERR "t_err" 6,
    KIND "kind" 7,
}

impl Fields {
    /// All columns.
    pub const ALL: Fields = Fields(0xff);

    /// The columns of [`ClosestRows`](super::ClosestRows).
    pub const OF_CLOSEST: Fields = Fields(Fields::ALL.0 & !Fields::KIND.0);

    /// The columns of [`CrossingRows`](super::CrossingRows).
    pub const OF_CROSSINGS: Fields = Fields::ALL;

    /// No column besides `t`.
    pub const NONE: Fields = Fields(0);

    /// Returns the column with a name, or `None` if no column that can be left out has this name.
    pub fn named(name: &str) -> Option<Fields> {
        Fields::NAMED.iter().find(|named| named.0 == name).map(|named| named.1)
    }

    /// The names of the columns in the set.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Fields::NAMED.iter().filter(move |named| self.contains(named.1)).map(|named| named.0)
    }

    /// Whether all of some columns are in the set.
    pub fn contains(self, fields: Fields) -> bool {
        self.0 & fields.0 == fields.0
    }
}

impl std::ops::BitOr for Fields {
    type Output = Fields;

    fn bitor(self, other: Fields) -> Fields {
        Fields(self.0 | other.0)
    }
}
