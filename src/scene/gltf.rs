//! glTF 2.0 files into a [`Scene`](super::Scene).
