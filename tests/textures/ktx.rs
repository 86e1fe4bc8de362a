//! KTX 2.0 files of ready-made blocks.

use ktx2::dfd::{Basic, Block};
use ktx2::{Format, Header, Index, LevelIndex, SupercompressionScheme};

/// A file of one picture.
pub struct File {
    pub format: Format,
    pub size: [u32; 2],
    /// Level 0 first.
    pub levels: Vec<Vec<u8>>,
    pub zstandard: bool,
    pub metadata: Vec<(&'static str, &'static [u8])>,
    /// How many array layers it claims.
    pub layers: u32,
}

impl File {
    pub fn new(format: Format, size: [u32; 2], levels: Vec<Vec<u8>>) -> Self {
        Self { format, size, levels, zstandard: false, metadata: Vec::new(), layers: 0 }
    }

    /// KTX 2.0, section 3.1: header, level index, data format descriptor, metadata, levels from the smallest.
    pub fn bytes(&self) -> Vec<u8> {
        let (descriptor, type_size) = Basic::from_format(self.format).expect("the library knows the format");
        let descriptor = Block::Basic(descriptor).to_vec();
        let mut metadata = Vec::new();
        for (key, value) in &self.metadata {
            metadata.extend((key.len() as u32 + 1 + value.len() as u32).to_le_bytes());
            metadata.extend(key.bytes().chain([0]).chain(value.iter().copied()));
            metadata.resize(metadata.len().next_multiple_of(4), 0);
        }
        let content = |level: &Vec<u8>| if self.zstandard { frame(level) } else { level.clone() };
        let contents: Vec<Vec<u8>> = self.levels.iter().map(content).collect();
        let index_end = Header::LENGTH + contents.len() * LevelIndex::LENGTH;
        let metadata_start = index_end + 4 + descriptor.len();
        let header = Header {
            format: Some(self.format),
            type_size,
            pixel_width: self.size[0],
            pixel_height: self.size[1],
            pixel_depth: 0,
            layer_count: self.layers,
            face_count: 1,
            level_count: contents.len() as u32,
            supercompression_scheme: self.zstandard.then_some(SupercompressionScheme::Zstandard),
            index: Index {
                dfd_byte_offset: index_end as u32,
                dfd_byte_length: 4 + descriptor.len() as u32,
                kvd_byte_offset: if metadata.is_empty() { 0 } else { metadata_start as u32 },
                kvd_byte_length: metadata.len() as u32,
                sgd_byte_offset: 0,
                sgd_byte_length: 0,
            },
        };
        // Each level begins at a multiple of 16, which suits all of these formats.
        let mut end = metadata_start + metadata.len();
        let mut starts = vec![0; contents.len()];
        for (start, content) in starts.iter_mut().zip(&contents).rev() {
            *start = end.next_multiple_of(16);
            end = *start + content.len();
        }
        let mut bytes = header.as_bytes().to_vec();
        for ((content, level), start) in contents.iter().zip(&self.levels).zip(&starts) {
            let entry = LevelIndex {
                byte_offset: *start as u64,
                byte_length: content.len() as u64,
                uncompressed_byte_length: level.len() as u64,
            };
            bytes.extend(entry.as_bytes());
        }
        bytes.extend((4 + descriptor.len() as u32).to_le_bytes());
        bytes.extend(descriptor);
        bytes.extend(metadata);
        for (content, start) in contents.iter().zip(&starts).rev() {
            bytes.resize(*start, 0);
            bytes.extend(content);
        }
        bytes
    }
}

/// A Zstandard frame of one block that is stored as it is (RFC 8878, 3.1.1).
fn frame(content: &[u8]) -> Vec<u8> {
    let mut frame = 0xfd2f_b528_u32.to_le_bytes().to_vec();
    // A single segment with four bytes of size.
    frame.push(0b1010_0000);
    frame.extend((content.len() as u32).to_le_bytes());
    let last_raw_block = 1 | (content.len() as u32) << 3;
    frame.extend(&last_raw_block.to_le_bytes()[..3]);
    frame.extend(content);
    frame
}
