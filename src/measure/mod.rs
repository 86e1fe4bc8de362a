//! Error metrics between pictures.

pub mod tiler;
