//! The format's author's encoder and decoder against this one (tests/loader/meshopt/make.mjs made the data).

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use proptest::prelude::*;
use serde::Deserialize;

use super::Compressed;

#[derive(Deserialize)]
struct Stream {
    name: String,
    mode: String,
    filter: String,
    count: u64,
    stride: u64,
    codes: String,
    decoded: String,
}

impl Stream {
    fn codes(&self) -> Vec<u8> {
        STANDARD.decode(&self.codes).unwrap()
    }

    fn byte_length(&self) -> u64 {
        self.count * self.stride
    }

    fn said(&self, codes: &[u8]) -> Compressed {
        Compressed {
            buffer: gltf::json::Index::new(0),
            byte_offset: 0,
            byte_length: codes.len() as u64,
            byte_stride: self.stride,
            count: self.count,
            mode: self.mode.clone(),
            filter: Some(self.filter.clone()),
        }
    }

    fn decode(&self, codes: &[u8]) -> Result<Vec<u8>, super::Problem> {
        self.said(codes).decode(codes, self.byte_length())
    }
}

fn streams() -> Vec<Stream> {
    serde_json::from_str(include_str!("../../../../tests/loader/meshopt/streams.json")).unwrap()
}

#[test]
fn every_stream_is_decoded_bit_by_bit_as_by_the_authors_decoder() {
    let streams = streams();
    assert!(streams.len() > 50);
    for stream in &streams {
        let decoded =
            stream.decode(&stream.codes()).unwrap_or_else(|(at, e)| panic!("{}: {at} {e}", stream.name));
        let wanted = STANDARD.decode(&stream.decoded).unwrap();
        let differs = decoded.iter().zip(&wanted).position(|(a, b)| a != b);
        assert_eq!((decoded.len(), differs), (wanted.len(), None), "{}", stream.name);
    }
}

/// What is cut, or goes on, is never taken for whole.
#[test]
fn streams_of_wrong_lengths_are_refused() {
    for stream in streams() {
        let codes = stream.codes();
        let ends = (0..codes.len()).step_by(1 + codes.len() / 200);
        for end in ends {
            assert!(
                stream.decode(&codes[..end]).is_err(),
                "{}: the first {end} of {}",
                stream.name,
                codes.len()
            );
        }
        let longer = [&codes[..], &[0; 40]].concat();
        assert!(stream.decode(&longer).is_err(), "{}: longer", stream.name);
    }
}

/// A few bytes get no gigabytes.
#[test]
fn room_is_made_only_for_what_codes_can_hold() {
    for (mode, stride, first) in
        [("ATTRIBUTES", 256, 0xa0), ("ATTRIBUTES", 256, 0xa1), ("TRIANGLES", 4, 0xe1), ("INDICES", 4, 0xd1)]
    {
        let mut codes = vec![0; 4096];
        codes[0] = first;
        let stream = Stream {
            name: String::new(),
            mode: mode.into(),
            filter: "NONE".into(),
            count: 3 << 40,
            stride,
            codes: String::new(),
            decoded: String::new(),
        };
        assert_eq!(stream.decode(&codes).unwrap_err().0, "byteLength", "{mode}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_streams_never_panic(
        which in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1..=255u8), 1..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
        filter in 0..5usize,
    ) {
        // Parsing the file each time would take most of the time.
        static STREAMS: std::sync::OnceLock<Vec<(Stream, Vec<u8>)>> = std::sync::OnceLock::new();
        let streams = STREAMS.get_or_init(|| streams().into_iter().map(|s| { let c = s.codes(); (s, c) }).collect());
        let (stream, codes) = &streams[which.index(streams.len())];
        let mut codes = codes.clone();
        for (at, flip) in flips {
            let at = at.index(codes.len());
            codes[at] ^= flip;
        }
        codes.truncate(cut.map_or(codes.len(), |at| at.index(codes.len() + 1)));
        let mut said = stream.said(&codes);
        said.filter = Some(["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"][filter].into());
        if let Ok(bytes) = said.decode(&codes, stream.byte_length()) {
            prop_assert_eq!(bytes.len() as u64, stream.byte_length());
        }
    }
}

#[cfg(feature = "measure")]
#[test]
fn files_that_are_changed_are_written_without_codes() {
    use crate::scene::{Scene, gltf::edit::Edit};

    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/loader/meshopt/packed-khr.glb");
    let written = Edit::read(&path).unwrap().to_glb();
    assert!(!String::from_utf8_lossy(&written).contains("meshopt"));
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("packed-khr.glb");
    std::fs::write(&plain, written).unwrap();
    let [a, b] = [path, plain].map(|path| format!("{:?}", Scene::load_moving(&path).unwrap()));
    assert!(a == b);
}
