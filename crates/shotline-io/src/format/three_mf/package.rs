//! The package: a zip file of parts, with relationships that name the model among them.

use std::io::{Cursor, Read, Write};

use roxmltree::Document;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::bytes::as_text;
use crate::diagnostic::RawDiagnostic;
use crate::error::WriteError;
use crate::xml::{offset_of, syntax_error};

/// The largest sum of the parts that are read, in bytes.
const MAX_EXPANDED: u64 = 512 << 20;

/// How many bytes the parts of a small file may have, and how many more for each of its bytes. Models shrink to a tenth
/// when they are packed; a file that is made to fill the memory shrinks to a thousandth.
const FREE: u64 = 16 << 20;
const PER_BYTE: u64 = 100;

/// The part with the relationships of the package, and the type of that to the model.
const RELATIONSHIPS: &str = "_rels/.rels";
const TO_MODEL: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

/// The part with the types of the others, and the part with the model.
const TYPES: (&str, &str) = (
    "[Content_Types].xml",
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
     <Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\
     <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\
     <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n",
);
const MODEL: &str = "3D/3dmodel.model";

/// Methods of packing in zip files that 3MF does not have, by their numbers there.
const METHODS: &[(u16, &str)] = &[
    (1, "Shrink"),
    (6, "Implode"),
    (9, "Deflate64"),
    (12, "bzip2"),
    (14, "LZMA"),
    (93, "Zstandard"),
    (95, "XZ"),
    (98, "PPMd"),
];

/// Packs the text of a model.
///
/// # Errors
/// If it is too large to be packed.
pub(super) fn pack(model: &str) -> Result<Vec<u8>, WriteError> {
    let relationships = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
         <Relationship Target=\"/{MODEL}\" Id=\"model\" Type=\"{TO_MODEL}\"/></Relationships>\n"
    );
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |name: &str, text: &str| -> Result<(), ZipError> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .large_file(text.len() as u64 >= u64::from(u32::MAX));
        zip.start_file(name, options)?;
        Ok(zip.write_all(text.as_bytes())?)
    };
    let added = add(TYPES.0, TYPES.1)
        .and_then(|()| add(RELATIONSHIPS, &relationships))
        .and_then(|()| add(MODEL, model));
    let packed = added.and_then(|()| zip.finish());
    packed.map(Cursor::into_inner).map_err(|error| WriteError::Unwritable(why(&error)))
}

/// A package that is open.
pub(super) struct Package<'b> {
    archive: ZipArchive<Cursor<&'b [u8]>>,
    /// How many more bytes its parts may have.
    left: u64,
    most: u64,
}

impl<'b> Package<'b> {
    pub(super) fn open(bytes: &'b [u8]) -> Result<Package<'b>, RawDiagnostic> {
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
            let message = format!("is no zip file, or a damaged one: {}", why(&error));
            RawDiagnostic::file(message).help("the file may be cut off; copy it again")
        })?;
        let most = FREE.saturating_add(PER_BYTE.saturating_mul(bytes.len() as u64)).min(MAX_EXPANDED);
        Ok(Package { archive, left: most, most })
    }

    /// The name of the part that holds the model.
    pub(super) fn model(&mut self) -> Result<String, RawDiagnostic> {
        let bytes = self.part(RELATIONSHIPS)?;
        let within = |diagnostic: RawDiagnostic| {
            let message = format!("{RELATIONSHIPS}: {}", diagnostic.message);
            RawDiagnostic::file(message).help("the package may be damaged; export it again")
        };
        let text = as_text(&bytes).map_err(within)?;
        let tree =
            Document::parse(text).map_err(|error| within(syntax_error(offset_of(text, &error), &error)))?;
        let target = tree
            .root_element()
            .children()
            .filter(|child| child.attribute("Type") == Some(TO_MODEL))
            .find_map(|child| child.attribute("Target"));
        let message = || RawDiagnostic::file("the relationship to a model is missing");
        target.map(str::to_owned).ok_or_else(|| within(message()))
    }

    /// The bytes of a part. Names begin at the root of the package, with or without a slash.
    pub(super) fn part(&mut self, name: &str) -> Result<Vec<u8>, RawDiagnostic> {
        let name = name.trim_start_matches('/');
        // The names of parts do not depend on case.
        let found = self.archive.index_for_name(name).or_else(|| {
            let mut names = self.archive.file_names().filter_map(Result::ok);
            let same = names.find(|other| other.eq_ignore_ascii_case(name))?.into_owned();
            self.archive.index_for_name(&same)
        });
        let Some(index) = found else {
            let message = format!("the package has no part '{name}'");
            return Err(RawDiagnostic::file(message).help("this may be another kind of zip file"));
        };
        let file = self.archive.by_index(index).map_err(|error| failed(name, &error))?;
        // The size in the head of a part may be false, so the bytes are counted.
        let mut bytes = Vec::new();
        file.take(self.left + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| failed(name, &ZipError::Io(error)))?;
        match self.left.checked_sub(bytes.len() as u64) {
            Some(left) => {
                self.left = left;
                Ok(bytes)
            }
            None => {
                let message =
                    format!("the parts that are needed unpack to more than {} MiB", self.most >> 20);
                let help = format!(
                    "a package may unpack to {} MiB and {PER_BYTE} times its size, and to {} MiB at most",
                    FREE >> 20,
                    MAX_EXPANDED >> 20
                );
                Err(RawDiagnostic::file(message).help(help))
            }
        }
    }
}

/// The error of a part that cannot be unpacked.
fn failed(name: &str, error: &ZipError) -> RawDiagnostic {
    // The method may be refused only when bytes are read, within an error of reading.
    let within = match error {
        ZipError::Io(error) => error.get_ref().and_then(|inner| inner.downcast_ref()),
        other => Some(other),
    };
    let Some(ZipError::CompressionMethodNotSupported(method)) = within else {
        let message = format!("the part '{name}' cannot be unpacked: {}", why(error));
        return RawDiagnostic::file(message).help("the file is damaged; copy it or export it again");
    };
    let known = METHODS.iter().find(|(number, _)| number == method);
    let method = known.map_or_else(|| format!("method {method}"), |(_, name)| (*name).into());
    RawDiagnostic::file(format!("the part '{name}' is packed by {method}, which is not supported"))
        .help("3MF files are packed by Deflate or not at all: unpack the file, and pack it again as a usual zip file")
}

fn why(error: &ZipError) -> String {
    match error {
        ZipError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}
