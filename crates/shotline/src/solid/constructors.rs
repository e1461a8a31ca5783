//! The typed constructors of the kinds, declared beside each `KIND` and gathered by the registry.

/// Declares the typed constructors of a kind, in the file of the solid: the name of its module, then each constructor with
/// its documentation and its arguments. These are the kind's parameters by name and in order, typed after the methods of
/// [`Params`](super::Params) that read them: `number`, `vector`, `coefficients`, or
/// `rows2` to `rows4` for rows of so many numbers. Those with a default may be left out.
///
/// The types that return shapes are above this module. So the constructors become a macro of the module's name, which
/// `shape` expands within `impl Shape`.
macro_rules! constructors {
    ($module:ident: $($(#[$doc:meta])* fn $name:ident($($arg:ident: $reads:ident),+);)+) => {
        macro_rules! $module {
            () => {
                $(
                    $(#[$doc])*
                    ///
                    /// # Errors
                    /// [`InvalidSolid`] says which parameter is wrong, what it is, and what is expected.
                    #[allow(non_snake_case, clippy::too_many_arguments)]
                    pub fn $name(
                        $($arg: $crate::solid::declared::argument!($reads)),+
                    ) -> Result<Shape, InvalidSolid> {
                        let values: &[&[f64]] = &[$(&$crate::solid::declared::numbers!($reads $arg)),+];
                        let kind = $crate::solid::declared::$module();
                        Shape::solid(kind, $crate::solid::Params::of(kind, values))
                    }
                )+
            };
        }
        pub(crate) use $module;

        /// For each constructor the names of its arguments.
        #[cfg(test)]
        pub(super) static ARGUMENTS: &[&[&str]] = &[$(&[$(stringify!($arg)),+]),+];
    };
}

/// The type of an argument.
macro_rules! argument {
    (number) => { f64 };
    (vector) => { impl Into<$crate::math::Vec3> };
    (coefficients) => { [f64; 10] };
    (rows2) => { impl AsRef<[[f64; 2]]> };
    (rows3) => { impl AsRef<[[f64; 3]]> };
    (rows4) => { impl AsRef<[[f64; 4]]> };
}

/// The numbers of an argument.
macro_rules! numbers {
    (number $arg:ident) => {
        [$arg]
    };
    (vector $arg:ident) => {
        $arg.into().to_array()
    };
    (coefficients $arg:ident) => {
        $arg
    };
    ($rows:ident $arg:ident) => {
        *$arg.as_ref().as_flattened()
    };
}

pub(crate) use {argument, constructors, numbers};

/// Each constructor takes the first parameters of the kind, all that have no default among them; one takes them all.
#[cfg(test)]
pub(super) fn conformance(kind: &super::Kind, constructors: &[&[&str]]) {
    let names: Vec<&str> = kind.params.iter().map(|param| param.name).collect();
    let required = kind.params.iter().filter(|param| param.default.is_none()).count();
    for arguments in constructors {
        assert!(
            arguments.len() >= required,
            "{}: a constructor without {}",
            kind.name,
            names[arguments.len()]
        );
        assert_eq!(**arguments, names[..arguments.len()], "{}", kind.name);
    }
    assert!(
        constructors.iter().any(|all| all.len() == names.len()),
        "{}: no constructor takes all",
        kind.name
    );
}
