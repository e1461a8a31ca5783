//! Where the page of a viewer is.

/// Where the page is.
#[derive(Clone, Debug)]
pub struct Address {
    pub port: u16,
    /// What a client must know: 128 random bits.
    pub token: String,
}

impl Address {
    /// The address for a browser.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Whether a host, as requests name it, is this server. Another name is that of a page elsewhere which had the name resolved
    /// to this machine.
    pub fn is_host(&self, host: &str) -> bool {
        ["127.0.0.1", "localhost"].iter().any(|name| host == format!("{name}:{}", self.port))
    }
}
