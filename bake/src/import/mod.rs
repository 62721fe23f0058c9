//! Model files in: glTF 2.0.
