//! Reads the request of a connection and decides what it may have: the page, the socket, or nothing.

use std::io::Read;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;

use super::address::Address;

/// The longest head of a request.
const MAX_HEAD: usize = 8 << 10;
/// The number of header lines.
const MAX_HEADERS: usize = 64;
/// How long a head may take to arrive.
const HEAD_TIMEOUT: Duration = Duration::from_secs(5);

/// What a client may have.
pub enum Request {
    /// The page.
    Page,
    /// The WebSocket of the page, and the key that accepts it.
    Socket(String),
}

/// Why a client gets nothing.
pub struct Refusal {
    pub status: u16,
    pub why: &'static str,
}

fn refusal<T>(status: u16, why: &'static str) -> Result<T, Refusal> {
    Err(Refusal { status, why })
}

/// Reads a request and checks that it comes from the page.
pub fn read(stream: &mut TcpStream, address: &Address) -> Result<Request, Refusal> {
    let head = read_head(stream)?;
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(&head) {
        Ok(httparse::Status::Complete(_)) => {}
        _ => return refusal(400, "this is not a request"),
    }
    let header = |name: &str| -> Option<&str> {
        let mut found = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
        let value = found.next()?;
        // A header that is there twice could mean two things.
        if found.next().is_some() { None } else { std::str::from_utf8(value.value).ok() }
    };
    if request.method != Some("GET") {
        return refusal(405, "only GET is answered");
    }
    if !header("host").is_some_and(|host| address.is_host(host)) {
        return refusal(403, "the request names another host");
    }
    let path = request.path.unwrap_or_default();
    let Some(rest) = path.strip_prefix('/').and_then(|path| path.strip_prefix(address.token.as_str())) else {
        return refusal(404, "there is nothing here; use the whole address that `shotline view` has printed");
    };
    match rest {
        "/" => Ok(Request::Page),
        "/socket" => socket(header, address),
        _ => refusal(404, "there is nothing here"),
    }
}

/// Accepts a WebSocket of the page, and of no other page.
fn socket<'h>(header: impl Fn(&str) -> Option<&'h str>, address: &Address) -> Result<Request, Refusal> {
    let origin = header("origin").and_then(|origin| origin.strip_prefix("http://"));
    if !origin.is_some_and(|host| address.is_host(host)) {
        return refusal(403, "the request comes from another page");
    }
    let has = |name: &str, word: &str| {
        header(name).is_some_and(|value| value.split(',').any(|part| part.trim().eq_ignore_ascii_case(word)))
    };
    let key = header("sec-websocket-key").filter(|key| !key.is_empty());
    match key {
        Some(key)
            if has("upgrade", "websocket")
                && has("connection", "upgrade")
                && header("sec-websocket-version") == Some("13") =>
        {
            Ok(Request::Socket(derive_accept_key(key.as_bytes())))
        }
        _ => refusal(400, "this is not the opening of a WebSocket"),
    }
}

/// Reads up to the empty line that ends the head.
fn read_head(stream: &mut TcpStream) -> Result<Vec<u8>, Refusal> {
    let begin = Instant::now();
    let mut head = Vec::new();
    let mut part = [0; 1024];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let left = HEAD_TIMEOUT.saturating_sub(begin.elapsed());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return refusal(408, "the request took too long");
        }
        match stream.read(&mut part) {
            Ok(0) => return refusal(400, "the request ends in its head"),
            Ok(count) => head.extend_from_slice(&part[..count]),
            Err(_) => return refusal(408, "the request took too long"),
        }
        if head.len() > MAX_HEAD {
            return refusal(431, "the head of the request is too long");
        }
    }
    Ok(head)
}
