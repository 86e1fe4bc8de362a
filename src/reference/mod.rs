//! The same frame in f64 on the CPU.
