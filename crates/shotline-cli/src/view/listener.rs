//! Accepts connections: a thread for each, and few of them.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use super::address::Address;
use super::page;
use super::request::{self, Request};
use super::server::Server;
use super::session;
use super::stage::Stage;

/// More connections at a time are refused: a browser opens a few.
const MAX_CONNECTIONS: usize = 16;
/// More pages at a time are refused: the pictures of each may take some hundred megabytes.
const MAX_PAGES: usize = 4;
/// The stack of a connection's thread: as large as that of a program, for scenes nest deeply.
const STACK: usize = 16 << 20;
/// How long one write to a client may wait. A client that does not read is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// A page that shows a scene, on 127.0.0.1, until it is dropped or [stopped](Viewer::stop).
#[derive(Debug)]
pub struct Viewer {
    address: Address,
    is_stopped: Arc<AtomicBool>,
}

impl Viewer {
    /// Starts a server at a port, or at a free one if that is 0.
    ///
    /// # Errors
    /// If the port is taken, or there are no random numbers.
    pub(crate) fn start(stage: Arc<Stage>, port: u16) -> io::Result<Viewer> {
        let listener = TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
        let mut random = [0; 16];
        getrandom::fill(&mut random).map_err(io::Error::other)?;
        let token = random.iter().map(|byte| format!("{byte:02x}")).collect();
        let address = Address { port: listener.local_addr()?.port(), token };
        let is_stopped = Arc::new(AtomicBool::new(false));
        let viewer = Viewer { address: address.clone(), is_stopped: Arc::clone(&is_stopped) };
        let server = Arc::new(Server {
            stage,
            address,
            is_stopped,
            pages: AtomicUsize::new(0),
            connections: AtomicUsize::new(0),
        });
        std::thread::Builder::new().name("viewer".into()).spawn(move || accept(&server, &listener))?;
        Ok(viewer)
    }

    /// The address of the page, with its token.
    pub fn url(&self) -> String {
        self.address.url()
    }

    /// Ends all connections soon, and accepts no more.
    pub fn stop(&self) {
        if !self.is_stopped.swap(true, Ordering::SeqCst) {
            // The listener waits for a connection; this one wakes it.
            let _ = TcpStream::connect((Ipv4Addr::LOCALHOST, self.address.port));
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.stop();
    }
}

fn accept(server: &Arc<Server>, listener: &TcpListener) {
    for stream in listener.incoming() {
        if server.is_stopped.load(Ordering::SeqCst) {
            return;
        }
        let Ok(stream) = stream else {
            // As when there are too many open files: others may be closed soon.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        let connection = Connection::new(server);
        let serve = move || {
            let _ = connection.serve(stream);
        };
        // Without a thread the stream is closed.
        let _ = std::thread::Builder::new().name("viewer client".into()).stack_size(STACK).spawn(serve);
    }
}

/// A connection, counted.
struct Connection {
    server: Arc<Server>,
    is_one_too_many: bool,
}

impl Connection {
    fn new(server: &Arc<Server>) -> Connection {
        let before = server.connections.fetch_add(1, Ordering::SeqCst);
        Connection { server: Arc::clone(server), is_one_too_many: before >= MAX_CONNECTIONS }
    }

    /// Answers the one request of a connection.
    fn serve(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        stream.set_nodelay(true)?;
        if self.is_one_too_many {
            return page::refuse(
                &mut stream,
                503,
                "there are too many connections; close other pages of the viewer",
            );
        }
        match request::read(&mut stream, &self.server.address) {
            Ok(Request::Page) => page::send(&mut stream, &self.server.address),
            Ok(Request::Socket(handshake)) => self.open_page(stream, &handshake),
            Err(refusal) => page::refuse(&mut stream, refusal.status, refusal.why),
        }
    }
}

impl Connection {
    /// Converses with a page, unless too many are open: each keeps pictures in memory.
    fn open_page(&self, mut stream: TcpStream, handshake: &str) -> io::Result<()> {
        let before = self.server.pages.fetch_add(1, Ordering::SeqCst);
        let outcome = if before < MAX_PAGES {
            session::run(stream, handshake, &self.server)
        } else {
            page::refuse(&mut stream, 503, "there are too many pages of the viewer; close some")
        };
        self.server.pages.fetch_sub(1, Ordering::SeqCst);
        outcome
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.server.connections.fetch_sub(1, Ordering::SeqCst);
    }
}
