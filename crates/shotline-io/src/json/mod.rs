//! JSON with the position of every value.

mod syntax;
mod token;
mod value_tree;

pub(crate) use self::syntax::parse;
pub(crate) use self::value_tree::{Content, Member, Tree, ValueId};
