//! Which columns of a result are requested.

/// A set of columns of [`ClosestRows`](super::ClosestRows) or [`CrossingRows`](super::CrossingRows). A column that is not
/// requested stays empty; `t` and the splits are always there.
///
/// ```
/// use shotline::query::batch::Columns;
/// let columns = Columns::NORMAL | Columns::PRIMITIVE;
/// assert!(columns.contains(Columns::NORMAL) && !columns.contains(Columns::PATH));
/// assert_eq!(Columns::named("t_err"), Some(Columns::T_ERR));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Columns(u16);

/// Declares the columns, each with its name and a bit of its own.
macro_rules! columns {
    ($($constant:ident $name:literal $bit:literal),* $(,)?) => {
        impl Columns {
            $(
                #[doc = concat!("The column `", $name, "`.")]
                pub const $constant: Columns = Columns(1 << $bit);
            )*

            /// The column with a name; `None` if there is none that can be left out.
            pub fn named(name: &str) -> Option<Columns> {
                match name {
                    $($name => Some(Columns::$constant),)*
                    _ => None,
                }
            }
        }
    };
}

columns! {
    NORMAL "normal" 0,
    OBJECT "object" 1,
    SURFACE "surface" 2,
    PRIMITIVE "primitive" 3,
    PATH "path" 4,
    ENTERING "entering" 5,
    T_ERR "t_err" 6,
    KIND "kind" 7,
}

impl Columns {
    /// All columns.
    pub const ALL: Columns = Columns(0xff);

    /// No column besides `t`.
    pub const NONE: Columns = Columns(0);

    /// Whether all of some columns are in the set.
    pub fn contains(self, columns: Columns) -> bool {
        self.0 & columns.0 == columns.0
    }
}

impl std::ops::BitOr for Columns {
    type Output = Columns;

    fn bitor(self, other: Columns) -> Columns {
        Columns(self.0 | other.0)
    }
}
