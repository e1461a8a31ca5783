//! The conversation with one page: it asks, and is answered, one message after the other.

use std::io;
use std::net::TcpStream;
use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::answer::Answer;
use super::answers::Answers;
use super::page;
use super::question::Asked;
use super::server::Server;

/// The longest message of a page: the names of all hidden objects are in it.
const MAX_MESSAGE: usize = 1 << 20;
/// How often the files of the scene are looked at while the page asks nothing.
const PAUSE: Duration = Duration::from_millis(250);

/// Answers a page until it goes, breaks the rules, or does not read what it is sent.
pub fn run(mut stream: TcpStream, key: &str, server: &Server) -> io::Result<()> {
    page::accept_socket(&mut stream, key)?;
    stream.set_read_timeout(Some(PAUSE))?;
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE))
        .max_frame_size(Some(MAX_MESSAGE))
        .write_buffer_size(0);
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    let mut answers = Answers::new(server);
    while !server.is_stopped.load(Ordering::SeqCst) {
        match socket.read() {
            Ok(Message::Text(text)) => {
                let answer = match serde_json::from_str::<Asked>(&text) {
                    Ok(Asked { id, question }) => answers.answer(id, question),
                    Err(error) => misunderstood(&text, &error),
                };
                send(&mut socket, answer)?;
            }
            Ok(Message::Binary(_)) => break,
            Ok(Message::Close(_)) | Err(Error::ConnectionClosed) => break,
            Ok(_) => {}
            Err(Error::Io(error)) if is_pause(&error) => {
                if let Some(news) = answers.news() {
                    send(&mut socket, Answer::Text(news))?;
                }
            }
            Err(_) => break,
        }
    }
    let _ = socket.close(None);
    Ok(())
}

/// The answer to what is no question, with its number if it has one.
fn misunderstood(text: &str, error: &serde_json::Error) -> Answer {
    let id = serde_json::from_str::<Value>(text).ok().and_then(|asked| asked.get("id").cloned());
    Answer::Text(json!({ "id": id, "error": format!("the question is not understood: {error}") }))
}

fn is_pause(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}

fn send(socket: &mut WebSocket<TcpStream>, answer: Answer) -> io::Result<()> {
    let message = match answer {
        Answer::Text(value) => Message::text(value.to_string()),
        Answer::Pixels { head, bytes } => Message::binary(framed(&head, &bytes)),
    };
    socket.send(message).map_err(io::Error::other)
}

/// The length of a head in four bytes, the head, the bytes.
fn framed(head: &Value, bytes: &[u8]) -> Vec<u8> {
    let head = head.to_string();
    let mut out = Vec::with_capacity(4 + head.len() + bytes.len());
    out.extend((head.len() as u32).to_le_bytes());
    out.extend(head.as_bytes());
    out.extend(bytes);
    out
}
