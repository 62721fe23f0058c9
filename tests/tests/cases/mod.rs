//! Inputs of strangers that once went wrong: what is right for each kind.

mod normals;
