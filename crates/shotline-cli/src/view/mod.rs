//! The viewer: a page on 127.0.0.1 that shows a scene, drawn by shotline itself.
//!
//! The page asks and the server answers, one message after the other over a WebSocket, so that a client can never have more than
//! one piece of work in flight. Pictures come in steps: coarse, whole, then with more samples.
//!
//! Only this machine reaches the server, and only a page that knows the token in the address, and comes from it.

mod address;
mod answer;
mod answers;
mod listener;
mod objects;
mod outline_lines;
mod page;
mod pane;
mod question;
mod request;
mod server;
mod session;
mod stage;
mod viewed_scene;

pub use listener::Viewer;
pub use stage::{Source, Stage};
