//! Error metrics between pictures.
