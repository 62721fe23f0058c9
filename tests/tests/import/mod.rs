//! What the importer makes of files: right ones, wrong ones, hostile ones; other crates as judges.

mod compressed;
mod crosscheck;
mod data;
mod drawn;
mod faults;
mod geometry;
mod hair;
mod instances;
mod io;
mod motion;
mod mutation;
mod obj;
mod support;
