//! The page, in one piece: it loads nothing else.

use std::io::{self, Write};
use std::net::TcpStream;

use super::address::Address;

/// The page, with the places of its style, its program and the token that allows both.
const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const PROGRAM: &str = concat!(
    include_str!("page/vectors.js"),
    include_str!("page/camera.js"),
    include_str!("page/connection.js"),
    include_str!("page/state.js"),
    include_str!("page/picture.js"),
    include_str!("page/overlay.js"),
    include_str!("page/pointer.js"),
    include_str!("page/tree.js"),
    include_str!("page/ray.js"),
    include_str!("page/slice.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
);

/// Sends the page. What it may load is its own text and its own socket.
pub fn send(stream: &mut TcpStream, address: &Address) -> io::Result<()> {
    let nonce = &address.token;
    let page = PAGE.replace("NONCE", nonce).replace("/*STYLE*/", STYLE).replace("/*PROGRAM*/", PROGRAM);
    let port = address.port;
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; img-src blob: data:; \
         connect-src ws://127.0.0.1:{port} ws://localhost:{port}; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'"
    );
    respond(
        stream,
        "200 OK",
        "text/html; charset=utf-8",
        &format!("Content-Security-Policy: {policy}\r\n"),
        &page,
    )
}

/// Tells why a request is not answered.
pub fn refuse(stream: &mut TcpStream, status: u16, why: &str) -> io::Result<()> {
    let phrase = match status {
        400 => "400 Bad Request",
        403 => "403 Forbidden",
        405 => "405 Method Not Allowed",
        408 => "408 Request Timeout",
        431 => "431 Request Header Fields Too Large",
        503 => "503 Service Unavailable",
        _ => "404 Not Found",
    };
    respond(stream, phrase, "text/plain; charset=utf-8", "", &format!("{why}\n"))
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, more: &str, body: &str) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{more}\
         Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.flush()
}

/// Accepts the opening of a WebSocket.
pub fn accept_socket(stream: &mut TcpStream, key: &str) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {key}\r\n\r\n"
    );
    stream.write_all(head.as_bytes())?;
    stream.flush()
}
