//! Tests of small inputs with one fault each: the files of `cases/` in the test data, and others of the same kinds.

mod combing;
mod hair;
mod import;
mod materials;
mod memory;
mod normals;
mod pictures;
mod rest;
