//! The buffers: in the file itself, in `data:` URIs, or in files below the folder.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::base64;
use super::fields::{Field, List, Read};
use crate::files::read_regular;
use crate::options::PathPolicy;
use crate::paths::resolve;

/// The largest buffer that is read, in bytes.
const MAX_BYTES: u64 = u32::MAX as u64;

/// The bytes of a buffer.
#[derive(Debug)]
enum Bytes<'b> {
    InFile(&'b [u8]),
    Read(Rc<Vec<u8>>),
}

/// The buffers of a file.
#[derive(Debug)]
pub(super) struct Buffers<'b> {
    buffers: Vec<Bytes<'b>>,
    /// How many bytes they have; a file that several of them name counts once.
    pub(super) total: usize,
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
}

impl<'b> Buffers<'b> {
    /// Reads all buffers. `bin` is the binary chunk of a GLB file.
    pub(super) fn read(
        list: List,
        bin: Option<&'b [u8]>,
        folder: &Path,
        paths: PathPolicy,
    ) -> Read<Buffers<'b>> {
        let mut source = Source { folder, paths, files: HashMap::new(), total: bin.map_or(0, <[u8]>::len) };
        let mut buffers = Vec::with_capacity(list.len());
        for (number, buffer) in list.iter().enumerate() {
            let what = format!("buffer {number}");
            let length = buffer.required("byteLength", &what)?;
            let promised = length.whole("\"byteLength\"")?;
            let bytes = match (buffer.get("uri"), bin.filter(|_| number == 0)) {
                (Some(uri), _) => Bytes::Read(source.of_uri(uri, &what)?),
                (None, Some(bin)) => Bytes::InFile(bin),
                (None, None) => {
                    let message = format!("{what} has no \"uri\", and is not the binary chunk of a GLB");
                    return Err(buffer.error(message));
                }
            };
            let found = bytes.get().len();
            if found < promised {
                let message = format!("{what} has {found} bytes, not {promised}");
                return Err(length.error(message).help("the buffer is cut off; copy it or export it again"));
            }
            buffers.push(bytes);
        }
        Ok(Buffers { buffers, total: source.total, files: source.files.into_keys().collect() })
    }

    /// The bytes of a buffer; none if there is no such buffer.
    pub(super) fn get(&self, number: usize) -> &[u8] {
        self.buffers.get(number).map_or(&[], Bytes::get)
    }
}

impl Bytes<'_> {
    fn get(&self) -> &[u8] {
        match self {
            Bytes::InFile(bytes) => bytes,
            Bytes::Read(bytes) => bytes,
        }
    }
}

/// Where the bytes of URIs come from.
struct Source<'a> {
    folder: &'a Path,
    paths: PathPolicy,
    files: HashMap<PathBuf, Rc<Vec<u8>>>,
    total: usize,
}

impl Source<'_> {
    fn of_uri(&mut self, field: Field, what: &str) -> Read<Rc<Vec<u8>>> {
        let uri = field.text("\"uri\"")?;
        if let Some(data) = uri.strip_prefix("data:") {
            let bytes = data.split_once(";base64,").and_then(|(_, text)| base64::decode(text));
            let bytes = bytes.ok_or_else(|| field.error(format!("the data of {what} are not Base64")))?;
            self.total += bytes.len();
            return Ok(Rc::new(bytes));
        }
        if uri.contains("://") {
            let message = format!("{what} lies elsewhere: files are read only from the folder of the scene");
            return Err(field.error(message).help("download it, and name it relative to the scene"));
        }
        let name = percent_decoded(uri).ok_or_else(|| {
            field.error(format!("the URI of {what} has % without two hexadecimal digits of UTF-8"))
        })?;
        let path = resolve(self.folder, self.folder, &name, self.paths)
            .map_err(|refusal| field.error(format!("{what}: {}", refusal.why)).help(refusal.help))?;
        if let Some(bytes) = self.files.get(&path) {
            return Ok(bytes.clone());
        }
        let bytes = read_regular(&path, MAX_BYTES).map_err(|error| {
            let message = format!("{what} cannot be read: {}", error.brief(&name));
            field.error(message).help("mend the file or name another one")
        })?;
        self.total += bytes.len();
        let bytes = Rc::new(bytes);
        self.files.insert(path, bytes.clone());
        Ok(bytes)
    }
}

/// A URI with its escapes resolved, as in `my%20part.bin`.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        rest = after;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let digits = rest.get(..2).filter(|digits| digits.iter().all(u8::is_ascii_hexdigit))?;
        bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
        rest = &rest[2..];
    }
    // A zero byte would end the name for the operating system.
    String::from_utf8(bytes).ok().filter(|name| !name.contains('\0'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_of_uris_are_resolved() {
        assert_eq!(percent_decoded("my%20gr%C3%B6%c3%9fe.bin").as_deref(), Some("my größe.bin"));
        for wrong in ["a%", "a%2", "a%zz", "a%+1", "%ff", "a%00"] {
            assert_eq!(percent_decoded(wrong), None, "{wrong}");
        }
    }
}
