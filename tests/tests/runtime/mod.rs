//! Tests of the runtime's public API on a real device: formulas in three implementations, single passes, whole
//! pictures, many frames. All tests share one device (`pelage_tests::gpu`).

mod contour_lines;
mod detail;
mod drawable;
mod false_colors;
mod fins;
mod frames;
mod gloss;
mod groom;
mod hair_motion;
mod ink;
mod ink_lines;
mod ink_specks;
mod inside_your_pass;
mod memory;
mod morphs;
mod painted_strokes;
mod paintings;
mod pictures;
mod scattering;
mod shader_twins;
mod shader_twins_detail;
mod shader_twins_ink;
mod shadows;
mod shadows_on_your_ground;
mod shells;
mod strands;
